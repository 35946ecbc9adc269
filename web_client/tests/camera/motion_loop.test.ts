import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { MotionLoop } from "../../src/camera/motion_loop";

const frames = new Map<number, (now: number) => void>();

function frame(now: number): void {
  for (const [id, next] of [...frames]) {
    frames.delete(id);
    next(now);
  }
}

beforeEach(() => {
  let id = 0;
  frames.clear();
  vi.stubGlobal("performance", { now: () => 1000 });
  vi.stubGlobal("requestAnimationFrame", (next: (now: number) => void) => {
    frames.set(++id, next);
    return id;
  });
  vi.stubGlobal("cancelAnimationFrame", (gone: number) => frames.delete(gone));
});
afterEach(() => vi.unstubAllGlobals());

it("tells the seconds between frames, at most a tenth, until the step is over", () => {
  const seconds: number[] = [];
  const loop = new MotionLoop(new AbortController().signal);
  loop.run((step) => seconds.push(step) < 3);
  frame(1020);
  frame(1070);
  expect(loop.running).toBe(true);
  frame(9000);
  expect(seconds).toEqual([expect.closeTo(0.02), expect.closeTo(0.05), 0.1]);
  expect(loop.running).toBe(false);
  expect(frames.size).toBe(0);
});

it("ends one motion where another begins, and all with the player", () => {
  const abort = new AbortController();
  const loop = new MotionLoop(abort.signal);
  const [first, second] = [vi.fn(() => true), vi.fn(() => true)];
  loop.run(first);
  loop.run(second);
  frame(1010);
  abort.abort();
  frame(1020);
  expect(first).not.toHaveBeenCalled();
  expect(second).toHaveBeenCalledOnce();
});
