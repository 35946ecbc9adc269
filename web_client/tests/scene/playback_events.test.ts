import { beforeEach, expect, it } from "vitest";
import { PlayerClock } from "../../src/scene/clock";
import { ProgressEvents } from "../../src/scene/playback_events";

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
