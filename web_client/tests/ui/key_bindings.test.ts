import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { keyName, obeyKeys } from "../../src/ui/key_bindings";

const event = (key: string, more: Record<string, unknown> = {}) =>
  Object.assign(new Event("keydown", { cancelable: true }), {
    key,
    shiftKey: false,
    ctrlKey: false,
    metaKey: false,
    altKey: false,
    ...more,
  }) as unknown as KeyboardEvent;

it.each([
  ["k", false, "k"],
  ["K", false, "k"], // caps lock
  ["L", true, "Shift+l"],
  ["ArrowLeft", true, "Shift+ArrowLeft"],
  ["?", true, "?"],
  ["7", true, "7"], // on a French keyboard
])("calls %s with shift %s %s", (key, shiftKey, name) => {
  expect(keyName(event(key, { shiftKey }))).toBe(name);
});

describe("keys that are obeyed", () => {
  const target = new EventTarget();
  const action = vi.fn();
  let ignored = false;
  let abort: AbortController;

  const press = (key: string, more = {}) => {
    const pressed = event(key, more);
    target.dispatchEvent(pressed);
    return pressed.defaultPrevented;
  };

  beforeEach(() => {
    abort = new AbortController();
    action.mockClear();
    ignored = false;
    const groups = [{ name: "Group", bindings: [{ keys: [" ", "k"], does: "Something", action }] }];
    obeyKeys(target, groups, () => ignored, abort.signal);
  });
  afterEach(() => abort.abort());

  it("do what the table says, and nothing else of the browser's", () => {
    expect(press("k")).toBe(true);
    expect(action).toHaveBeenCalledExactlyOnceWith("k");
    expect(press("x")).toBe(false);
  });

  it.each(["ctrlKey", "metaKey", "altKey"])("are left alone with %s", (modifier) => {
    expect(press("k", { [modifier]: true })).toBe(false);
    expect(action).not.toHaveBeenCalled();
  });

  it("are left to whom they are for", () => {
    ignored = true;
    expect(press("k")).toBe(false);
    ignored = false;
    const used = event("k");
    used.preventDefault();
    target.dispatchEvent(used);
    expect(action).not.toHaveBeenCalled();
  });
});
