import { expect, it, vi } from "vitest";
import { LatePart } from "../../src/ui/late_part";

const settled = () => new Promise((resolve) => setTimeout(resolve));

it("is loaded when it is first used, once, and used in order", async () => {
  const load = vi.fn(async () => "part");
  const late = new LatePart(load, vi.fn(), new AbortController().signal);
  expect(load).not.toHaveBeenCalled();
  const used: string[] = [];
  late.use((part) => used.push(`first ${part}`));
  late.use((part) => used.push(`second ${part}`));
  expect(late.here).toBeNull();
  await settled();
  expect(late.here).toBe("part");
  late.use((part) => used.push(`third ${part}`));
  expect(used).toEqual(["first part", "second part", "third part"]);
  expect(load).toHaveBeenCalledOnce();
});

it("says that it cannot be loaded, and is tried again by the next use", async () => {
  const cause = new TypeError("Failed to fetch");
  const load = vi.fn().mockRejectedValueOnce(cause).mockResolvedValue("part");
  const failed = vi.fn();
  const late = new LatePart(load, failed, new AbortController().signal);
  const use = vi.fn();
  late.use(use);
  await settled();
  expect(failed).toHaveBeenCalledExactlyOnceWith(expect.stringContaining("could not be loaded"), cause);
  late.use(use);
  await settled();
  expect(use).toHaveBeenCalledExactlyOnceWith("part");
});

it("is not used, and nothing is said, once there is no more use for it", async () => {
  const abort = new AbortController();
  const [use, failed] = [vi.fn(), vi.fn()];
  new LatePart(async () => "part", failed, abort.signal).use(use);
  new LatePart(() => Promise.reject(new Error("gone")), failed, abort.signal).use(use);
  abort.abort();
  await settled();
  expect(use).not.toHaveBeenCalled();
  expect(failed).not.toHaveBeenCalled();
});
