import { beforeEach, expect, it, vi } from "vitest";
import { SceneBuffer } from "../../src/scene/buffer";
import { PlayerClock } from "../../src/scene/clock";
import { Playback, ProgressEvents } from "../../src/scene/playback";
import type { SceneSource } from "../../src/source/scene_source";
import { draw, manifest, slice } from "../scene";

const told = vi.fn();
const stream = {
  playheadAt: () => {},
  play: (time: number, rate: number) => told("play", time, rate),
  pause: (time: number) => told("pause", time),
  seek: (time: number) => told("seek", time),
} as unknown as SceneSource;
let playback: Playback;

/** A scene of two seconds, of which the first is here. */
beforeEach(() => {
  const buffer = new SceneBuffer(manifest({ slices: [slice(0, 1, ["a"]), slice(1, 2, ["b"])] }));
  draw(buffer, "a");
  playback = new Playback(new PlayerClock(0, 2), buffer, stream);
  told.mockClear();
});

it("asks the server for what is missing at a new time, and else tells only where the playhead is", () => {
  playback.seek(1.5);
  playback.seek(0.5);
  playback.play();
  playback.seek(0.25);
  expect(told.mock.calls).toEqual([
    ["seek", 1.5],
    ["pause", 0.5],
    ["play", 0.5, 1],
    ["play", 0.25, 1],
  ]);
});

it("tells the server once when it waits, and once when it goes on", () => {
  playback.seek(0.95);
  playback.play();
  playback.tick(0);
  told.mockClear();
  for (const now of [0.1, 0.2, 0.3]) expect(playback.tick(now)).toBe(0.95);
  expect(playback.moving).toBe(false);
  draw(playback.buffer, "b");
  playback.tick(0.4);
  playback.tick(0.5);
  expect(playback.moving).toBe(true);
  expect(told.mock.calls.map(([kind]) => kind)).toEqual(["pause", "play"]);
});

it("does not go on for a moment after it has waited", () => {
  const slices = Array.from({ length: 4 }, (_, k) => slice(k, k + 1, [`${k}`]));
  const buffer = new SceneBuffer(manifest({ end: 4, slices }));
  let line = 0;
  playback = new Playback(new PlayerClock(0, 4), buffer, stream, () => line);
  playback.play();
  playback.tick(0);
  draw(buffer, "0");
  playback.tick(0.1);
  expect(playback.moving).toBe(false);
  line = 1000; // the rest will come in time
  playback.tick(0.2);
  expect(playback.moving).toBe(true);
  line = 0; // once it moves it goes on as long as it can
  for (let now = 0.3; now < 1; now += 0.1) playback.tick(now);
  expect(playback.clock.time).toBeGreaterThan(0.5);
});

it("gathers more after it has waited than to begin with", () => {
  const slices = Array.from({ length: 20 }, (_, k) => slice(k / 2, (k + 1) / 2, [`${k}`]));
  const buffer = new SceneBuffer(manifest({ end: 10, slices }));
  playback = new Playback(new PlayerClock(0, 10), buffer, stream);
  playback.play();
  playback.tick(0);
  for (const k of [0, 1, 2]) draw(buffer, `${k}`);
  let now = 0;
  const run = (seconds: number) => {
    for (const until = now + seconds; now < until; now += 0.1) playback.tick(now);
  };
  run(1);
  expect(playback.moving).toBe(true);
  run(2);
  for (const k of [3, 4, 5, 6]) draw(buffer, `${k}`);
  run(1);
  expect(playback.moving).toBe(false);
  for (const k of [7, 8, 9, 10, 11]) draw(buffer, `${k}`);
  run(1);
  expect(playback.moving).toBe(true);
});

it("stands while the page is hidden, if it played", () => {
  playback.pageHidden(true);
  expect(told).not.toHaveBeenCalled();
  playback.play();
  playback.pageHidden(true);
  playback.pageHidden(false);
  expect(told.mock.calls.map(([kind]) => kind)).toEqual(["play", "pause", "play"]);
});

it("tells a new rate only while it plays", () => {
  playback.setRate(2);
  expect(told).not.toHaveBeenCalled();
  playback.play();
  expect(told).toHaveBeenLastCalledWith("play", 0, 2);
});

let clock: PlayerClock;
let progress: ProgressEvents;

/** Advance to so many seconds and tell what has happened. */
const at = (seconds: number, ready = true, pictured = true) => {
  clock.tick(seconds, () => ready);
  return progress.since(clock, pictured, 1000 * seconds);
};

beforeEach(() => {
  clock = new PlayerClock(0, 1);
  clock.loop = false;
  progress = new ProgressEvents();
  at(0);
});

it("tells the first picture once", () => {
  progress = new ProgressEvents();
  expect(at(0, true, false)).not.toContain("firstpicture");
  expect(at(0.1)).toContain("firstpicture");
  expect(at(0.2)).toEqual([]);
});

it("tells playing, standing and the end", () => {
  clock.play();
  expect(at(1)).toEqual(["play"]);
  clock.pause();
  expect(at(1.1)).toEqual(["pause"]);
  clock.seek(0.95);
  clock.play();
  at(2);
  expect(at(2.2)).toEqual(["timeupdate", "pause", "ended"]);
});

it("tells waiting for data, and going on", () => {
  clock.play();
  at(1);
  expect(at(1.1, false)).toEqual(["stalled"]);
  expect(at(1.2, false)).toEqual([]);
  expect(at(1.25)).toContain("playing");
});

it("tells a running playhead four times a second, and every seek", () => {
  clock.play();
  at(1);
  const told = [1.05, 1.1, 1.15, 1.2, 1.25, 1.3, 1.35].filter((seconds) => at(seconds).includes("timeupdate"));
  expect(told).toHaveLength(2);
  clock.pause();
  at(2);
  clock.seek(0.7);
  expect(at(2.01)).toEqual(["timeupdate"]);
});
