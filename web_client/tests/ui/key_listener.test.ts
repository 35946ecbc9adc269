import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { listenForKeys, mayBeObeyed } from "../../src/ui/key_listener";

const event = (key: string, more: Record<string, unknown> = {}) =>
  Object.assign(new Event("keydown", { cancelable: true }), { key, ...more }) as unknown as KeyboardEvent;

const target = new EventTarget();
const heard = vi.fn();
let ignored = false;
let abort: AbortController;

beforeEach(() => {
  abort = new AbortController();
  heard.mockClear();
  ignored = false;
  listenForKeys(target, heard, () => ignored, abort.signal);
});
afterEach(() => abort.abort());

it("hears keys until it is told to stop", () => {
  const pressed = event("k");
  target.dispatchEvent(pressed);
  expect(heard).toHaveBeenCalledExactlyOnceWith(pressed);
  abort.abort();
  target.dispatchEvent(event("k"));
  expect(heard).toHaveBeenCalledOnce();
});

it.each(["ctrlKey", "metaKey", "altKey"])("leaves keys alone with %s", (modifier) => {
  target.dispatchEvent(event("k", { [modifier]: true }));
  expect(heard).not.toHaveBeenCalled();
});

it("leaves keys to whom they are for", () => {
  ignored = true;
  target.dispatchEvent(event("k"));
  ignored = false;
  const used = event("k");
  used.preventDefault();
  target.dispatchEvent(used);
  expect(heard).not.toHaveBeenCalled();
});

it.each([
  ["k", true],
  [" ", true],
  ["PageDown", true],
  ["Tab", false],
  ["Enter", false],
  ["Escape", false],
  ["F5", false],
  ["Shift", false],
])("takes %s for a key of a player: %s", (key, taken) => {
  expect(mayBeObeyed(event(key))).toBe(taken);
});
