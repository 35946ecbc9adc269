import { expect, it } from "vitest";
import { drawnTime, momentOf, normalised } from "../../src/player/moment";
import { manifest, slice } from "../scene";

const scene = manifest({
  end: 4,
  segments: [
    { start: 0, end: 2 },
    { start: 2, end: 4 },
  ],
  slices: [slice(0, 1, ["a"]), slice(1, 2, ["b"]), slice(2, 4, ["c"], [], 1)],
});

it("is cut to the segment of its time", () => {
  expect(momentOf(scene, 1.9, 1.8, 2.1)).toEqual({ time: 1.9, from: 1.8, until: 2 });
  expect(momentOf(scene, 2.05, 1.95, 2.2)).toEqual({ time: 2.05, from: 2, until: 2.2 });
  expect(momentOf(scene, 1)).toEqual({ time: 1, from: 1, until: 1 });
});

it("is drawn at the playhead's time, as far as the order goes", () => {
  const moment = { time: 1, from: 0.9, until: 1.1 };
  expect(drawnTime(moment, 1.03)).toBe(1.03);
  expect(drawnTime(moment, 0.95)).toBe(0.95);
  expect(drawnTime(moment, 1.2)).toBe(1.1);
  expect(drawnTime(moment, 0.8)).toBe(0.9);
});

it("is drawn exactly as it was ordered where no eye sees the difference", () => {
  expect(drawnTime({ time: 1, from: 0.9, until: 1.1 }, 1.0015)).toBe(1);
});

it("is drawn as it was ordered when the playhead jumps", () => {
  expect(drawnTime({ time: 0.01, from: 0.01, until: 0.07 }, 3.99)).toBe(0.01); // the order for after the loop
  expect(drawnTime({ time: 3, from: 3, until: 3 }, 1)).toBe(3); // the order from before a seek
});

it("is given to the renderer in the time of its segment, also at the segment's end", () => {
  const moment = momentOf(scene, 1.9, 1.9, 2);
  expect(normalised(scene, moment, 1.5)).toBe(0.75);
  expect(normalised(scene, moment, 2)).toBe(1);
  expect(normalised(scene, momentOf(scene, 2), 2)).toBe(0);
  expect(normalised(manifest(), momentOf(manifest(), 1), 1)).toBe(0);
});
