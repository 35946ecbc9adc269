import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { FlyMode } from "../../src/camera/fly_mode";

const window = new EventTarget();
let frames: ((now: number) => void)[] = [];
let abort: AbortController;
const flight = { travel: vi.fn(), release: vi.fn() };
let fly: FlyMode;

function key(type: "keydown" | "keyup", code: string, more: Record<string, unknown> = {}): Event {
  const fields = { code, shiftKey: false, ctrlKey: false, metaKey: false, altKey: false, ...more };
  const event = Object.assign(new Event(type, { cancelable: true }), fields);
  window.dispatchEvent(event);
  return event;
}

function frame(now: number): void {
  for (const next of frames.splice(0)) next(now);
}

beforeEach(() => {
  frames = [];
  vi.stubGlobal("requestAnimationFrame", (next: (now: number) => void) => frames.push(next));
  vi.stubGlobal("cancelAnimationFrame", () => {});
  vi.stubGlobal("performance", { now: () => 0 });
  vi.stubGlobal("addEventListener", window.addEventListener.bind(window));
  flight.travel.mockClear();
  flight.release.mockClear();
  abort = new AbortController();
  fly = new FlyMode(window, flight, abort.signal);
});
afterEach(() => {
  abort.abort();
  vi.unstubAllGlobals();
});

describe("flying", () => {
  it("uses no keys until it is switched on", () => {
    expect(key("keydown", "KeyW").defaultPrevented).toBe(false);
    fly.toggle();
    expect(key("keydown", "KeyW").defaultPrevented).toBe(true);
    expect(key("keydown", "KeyW", { ctrlKey: true }).defaultPrevented).toBe(false);
    expect(key("keydown", "KeyK").defaultPrevented).toBe(false);
  });

  it("goes on while keys are held, three times as fast with Shift, and lets go afterwards", () => {
    fly.toggle();
    key("keydown", "KeyW");
    key("keydown", "KeyA");
    frame(100);
    expect(flight.travel).toHaveBeenLastCalledWith(expect.closeTo(-0.05), 0, expect.closeTo(0.05));
    key("keydown", "KeyE", { shiftKey: true });
    frame(200);
    expect(flight.travel).toHaveBeenLastCalledWith(expect.closeTo(-0.15), expect.closeTo(0.15), expect.closeTo(0.15));
    for (const code of ["KeyW", "KeyA", "KeyE"]) key("keyup", code);
    frame(300);
    expect(flight.travel).toHaveBeenCalledTimes(2);
    expect(flight.release).toHaveBeenCalledOnce();
    expect(frames).toEqual([]); // nothing runs at rest
  });

  it("stops when the window loses the keys", () => {
    fly.toggle();
    key("keydown", "KeyD");
    window.dispatchEvent(new Event("blur"));
    frame(100);
    expect(flight.travel).not.toHaveBeenCalled();
  });
});
