import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { SceneCanvas } from "../../src/player/scene_canvas";
import { LADDER } from "../../src/renderer/fineness";
import { sightOf, type View } from "../../src/scene/view";
import type { SceneSource, SourceEvents } from "../../src/source/scene_source";
import { fakeCanvas } from "../canvas";
import { twoSegments, WorkerDouble } from "../worker_double";

vi.mock("../../src/worker/start_worker", () => ({
  startWorker: () => new WorkerDouble(),
  decompressor: () => new Promise(() => {}),
}));

const view: View = {
  pose: { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [0, 0, 0] },
  camera: { width: 8, height: 8, fx: 8, fy: 8, cx: 4, cy: 4, near: 0.1 },
};

const all = Number.POSITIVE_INFINITY;
let frames: ((now: number) => void)[];
let draw: ReturnType<typeof vi.fn>;
let player: SceneCanvas;
let busy: boolean;

/** A complete scene that plays, on a device that is never done with a picture while it is `busy`. */
beforeEach(() => {
  frames = [];
  draw = vi.fn();
  busy = true;
  vi.stubGlobal("document", { addEventListener: () => {} });
  vi.stubGlobal("addEventListener", () => {});
  vi.stubGlobal("requestAnimationFrame", (callback: (now: number) => void) => frames.push(callback));
  vi.stubGlobal("cancelAnimationFrame", () => frames.splice(0));
  const device = { clientWaitSync: () => (busy ? 1 : 0) }; // every constant of the context is 1, so that of a timeout, too
  const silent = () => {};
  let source: SourceEvents | undefined;
  player = new SceneCanvas({
    canvas: fakeCanvas({ drawArraysInstanced: draw, ...device }),
    source: (events) => {
      source = events;
      return { playheadAt: silent, play: silent, pause: silent, close: silent } as unknown as SceneSource;
    },
    time: 0,
    playing: true,
    antialiased: null,
    view: () => view,
    onManifest: silent,
    onFrame: silent,
    onError: silent,
  });
  source?.manifest(twoSegments());
  WorkerDouble.last.decodeAll();
});

afterEach(() => {
  player.dispose();
  vi.unstubAllGlobals();
});

/** A frame of the browser, and the worker's answer to what it asked. */
function browserFrame(now: number): void {
  const asked = WorkerDouble.last.orders.length;
  for (const callback of frames.splice(0)) callback(now);
  if (WorkerDouble.last.orders.length > asked) WorkerDouble.last.order();
}

it("waits with the next picture until the device is done", () => {
  for (let i = 0; i < 5; i++) browserFrame(16 * i);
  expect(draw).toHaveBeenCalledOnce();
});

it("gives whoever drives something to draw at every frame, however busy the device is", () => {
  player.drive(true);
  const shots = [];
  for (let i = 0; i < 10; i++) {
    const asked = WorkerDouble.last.orders.length;
    shots.push(player.step(16 * i, [view, view], sightOf([view]), all)?.shots ?? []);
    if (WorkerDouble.last.orders.length > asked) WorkerDouble.last.order();
  }
  expect(shots.map((both) => both.length)).toEqual([0, ...Array(9).fill(2)]);
  // The first picture stands until there is an order for a playhead that moves.
  expect(new Set(shots.slice(1).map(([left]) => left.time)).size).toBe(8);
  expect(player.stats.framesDrawn).toBe(9);
});

it("asks the browser for no frames while another drives, and for one when it may draw again", () => {
  browserFrame(0);
  player.drive(true);
  player.invalidate();
  expect(frames).toHaveLength(0);
  expect(draw).not.toHaveBeenCalled();
  player.drive(false);
  expect(frames).toHaveLength(1);
  browserFrame(16);
  expect(draw).toHaveBeenCalledOnce();
});

const budgets = () => WorkerDouble.last.orders.map(({ request }) => request.budget);

it("orders as many splats at most as the page, the quality and whoever drives allow", () => {
  browserFrame(0);
  player.splatBudget = 200_000;
  browserFrame(16);
  player.quality = "low";
  player.splatBudget = 70_000;
  browserFrame(32);
  player.drive(true);
  player.step(48, [view, view], sightOf([view]), 60_000);
  WorkerDouble.last.order();
  player.step(64, [view, view], sightOf([view]), all);
  expect(budgets()).toEqual([Infinity, 200_000, 70_000, 60_000, 70_000]);
});

it("has fewer splats while it moves on a slow device, and is settled by an order of all", async () => {
  busy = false;
  vi.spyOn(player.renderer.quality, "moving", "get").mockReturnValue(LADDER.length - 1);
  for (let now = 0; now < 100; now += 16) browserFrame(now);
  expect(budgets().at(-1)).toBe(100_000);
  player.playback?.pause();
  let settled = false;
  void player.settled().then(() => {
    settled = true;
  });
  for (let now = 100; frames.length > 0 && now < 2000; now += 16) {
    browserFrame(now);
    await Promise.resolve();
    if (budgets().at(-1) === 100_000) expect(settled).toBe(false);
  }
  expect([settled, budgets().at(-1)]).toEqual([true, Infinity]);
});
