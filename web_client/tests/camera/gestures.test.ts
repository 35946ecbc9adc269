import { afterEach, beforeEach, describe, expect, it, type Mocked, vi } from "vitest";
import { type CameraMotion, listenForGestures } from "../../src/camera/gestures";

let abort: AbortController;
let target: HTMLElement;
let motion: Mocked<CameraMotion>;
const tap = vi.fn();
let zooms = true;

function pointer(type: string, x: number, y: number, more: Record<string, unknown> = {}): void {
  const fields = { pointerId: 1, pointerType: "mouse", button: 0, clientX: x, clientY: y, shiftKey: false, ...more };
  target.dispatchEvent(Object.assign(new Event(`pointer${type}`), fields));
}

function press(more: Record<string, unknown> = {}): void {
  pointer("down", 100, 100, more);
  pointer("up", 100, 100, more);
}

beforeEach(() => {
  vi.useFakeTimers();
  target = Object.assign(new EventTarget(), {
    setPointerCapture: vi.fn(),
    getBoundingClientRect: () => ({ left: 30, top: 20 }),
  }) as unknown as HTMLElement;
  motion = { turn: vi.fn(), zoom: vi.fn(), pan: vi.fn(), release: vi.fn(), focus: vi.fn() };
  tap.mockClear();
  zooms = true;
  abort = new AbortController();
  listenForGestures(target, motion, { wheelZooms: () => zooms, onTap: tap }, abort.signal);
});
afterEach(() => {
  abort.abort();
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

describe("a tap", () => {
  it("is told once no second one can follow", () => {
    press();
    vi.advanceTimersByTime(200);
    expect(tap).not.toHaveBeenCalled();
    vi.advanceTimersByTime(100);
    expect(tap).toHaveBeenCalledOnce();
  });

  it("may tremble, a finger more than a mouse, and does not turn the camera", () => {
    for (const pointerType of ["mouse", "touch"]) {
      const far = pointerType === "mouse" ? 3 : 9;
      pointer("down", 100, 100, { pointerType });
      pointer("move", 100 + far, 100, { pointerType });
      pointer("up", 100 + far, 100, { pointerType });
      vi.runAllTimers();
    }
    expect(tap).toHaveBeenCalledTimes(2);
    expect(motion.turn).not.toHaveBeenCalled();
  });

  it("is the first button's alone, and not the pan of a held shift key", () => {
    press({ button: 2 });
    press({ shiftKey: true });
    vi.runAllTimers();
    expect(tap).not.toHaveBeenCalled();
  });

  it("is none that the browser cancels", () => {
    pointer("down", 100, 100);
    pointer("cancel", 100, 100);
    vi.runAllTimers();
    expect(tap).not.toHaveBeenCalled();
  });
});

it("takes two taps as a double one, which looks at the point under it and is no tap", () => {
  press();
  vi.advanceTimersByTime(200);
  press();
  vi.runAllTimers();
  expect(motion.focus).toHaveBeenCalledExactlyOnceWith(70, 80);
  expect(tap).not.toHaveBeenCalled();
});

it("turns with a drag from where it leaves the slack", () => {
  pointer("down", 100, 100);
  pointer("move", 110, 100);
  pointer("up", 110, 100);
  vi.runAllTimers();
  expect(motion.turn).toHaveBeenCalledExactlyOnceWith(expect.closeTo(6 * 0.006), 0);
  expect(tap).not.toHaveBeenCalled();
});

it("lets go of the camera with the last finger of a drag, and not with a tap", () => {
  press();
  vi.runAllTimers();
  expect(motion.release).not.toHaveBeenCalled();
  for (const pointerId of [1, 2]) pointer("down", 100 * pointerId, 100, { pointerType: "touch", pointerId });
  pointer("move", 300, 100, { pointerType: "touch", pointerId: 2 });
  pointer("up", 300, 100, { pointerType: "touch", pointerId: 2 });
  expect(motion.release).not.toHaveBeenCalled();
  pointer("cancel", 100, 100, { pointerType: "touch" });
  expect(motion.release).toHaveBeenCalledOnce();
});

it("takes two fingers that rest for no tap", () => {
  for (const pointerId of [1, 2]) pointer("down", 100 * pointerId, 100, { pointerType: "touch", pointerId });
  for (const pointerId of [1, 2]) pointer("up", 100 * pointerId, 100, { pointerType: "touch", pointerId });
  vi.runAllTimers();
  expect(tap).not.toHaveBeenCalled();
});

it("zooms with two fingers, which are no tap even if one of them rests", () => {
  pointer("down", 100, 100, { pointerType: "touch" });
  pointer("down", 200, 100, { pointerType: "touch", pointerId: 2 });
  pointer("move", 300, 100, { pointerType: "touch", pointerId: 2 });
  pointer("up", 300, 100, { pointerType: "touch", pointerId: 2 });
  pointer("up", 100, 100, { pointerType: "touch" });
  vi.runAllTimers();
  expect(motion.zoom).toHaveBeenCalledExactlyOnceWith(0.5);
  expect(tap).not.toHaveBeenCalled();
});

it("leaves the wheel to the page while it is not to zoom", () => {
  const roll = () => {
    const event = Object.assign(new Event("wheel", { cancelable: true }), { deltaY: 100, deltaMode: 0 });
    target.dispatchEvent(event);
    return event.defaultPrevented;
  };
  vi.stubGlobal("WheelEvent", { DOM_DELTA_PIXEL: 0 });
  expect(roll()).toBe(true);
  expect(motion.zoom).toHaveBeenCalledOnce();
  expect(motion.release).toHaveBeenCalledOnce(); // each notch is a step by itself
  zooms = false;
  expect(roll()).toBe(false);
  expect(motion.zoom).toHaveBeenCalledOnce();
});
