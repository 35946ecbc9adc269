import { expect, it, vi } from "vitest";
import { keyName, obey } from "../../src/ui/key_bindings";

const event = (key: string, shiftKey = false) =>
  Object.assign(new Event("keydown", { cancelable: true }), { key, shiftKey }) as unknown as KeyboardEvent;

it.each([
  ["k", false, "k"],
  ["K", false, "k"], // caps lock
  ["L", true, "Shift+l"],
  ["ArrowLeft", true, "Shift+ArrowLeft"],
  ["?", true, "?"],
  ["7", true, "7"], // on a French keyboard
])("calls %s with shift %s %s", (key, shiftKey, name) => {
  expect(keyName(event(key, shiftKey))).toBe(name);
});

it("does what the table says, and nothing else of the browser's", () => {
  const action = vi.fn();
  const press = obey([{ name: "Group", bindings: [{ keys: [" ", "k"], does: "Something", action }] }]);
  const [known, other] = [event("k"), event("x")];
  press(known);
  press(other);
  expect(action).toHaveBeenCalledExactlyOnceWith("k");
  expect([known.defaultPrevented, other.defaultPrevented]).toEqual([true, false]);
});
