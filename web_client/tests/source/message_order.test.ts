import { expect, it, vi } from "vitest";
import { MessageOrder } from "../../src/source/message_order";

function order() {
  const told: unknown[] = [];
  const failed = vi.fn();
  const messages = new MessageOrder<string>((message) => told.push(message), failed);
  return { messages, told, failed };
}

it("takes what is read before the messages that come meanwhile, and these in their order", async () => {
  const { messages, told } = order();
  messages.put("a");
  messages.read(
    async () => "page",
    (page) => told.push(page),
  );
  messages.put("b");
  messages.put("c");
  expect(told).toEqual(["a"]);
  await vi.waitFor(() => expect(told).toEqual(["a", "page", "b", "c"]));
  messages.put("d");
  expect(told.at(-1)).toBe("d");
});

it("waits again where what comes next is read, too", async () => {
  const told: string[] = [];
  const messages: MessageOrder<string> = new MessageOrder((message) => {
    messages.read(
      async () => message,
      (read) => told.push(read),
    );
  }, vi.fn());
  for (const message of ["a", "b", "c"]) messages.put(message);
  await vi.waitFor(() => expect(told).toEqual(["a", "b", "c"]));
});

it("takes at once what is there", () => {
  const { messages, told } = order();
  messages.read(
    () => "index",
    (index) => told.push(index),
  );
  expect(told).toEqual(["index"]);
});

it("tells what cannot be read, and receives nothing more", async () => {
  const { messages, told, failed } = order();
  const wrong = new Error("wrong");
  messages.read(() => {
    throw wrong;
  }, vi.fn());
  expect(failed).toHaveBeenCalledExactlyOnceWith(wrong);
  messages.read(() => Promise.reject(wrong), vi.fn());
  messages.put("a");
  await vi.waitFor(() => expect(failed).toHaveBeenCalledTimes(2));
  expect(told).toEqual([]);
});
