import { expect, it } from "vitest";
import { describeCapture } from "../../src/console/submit_page";
import type { Capture } from "../../src/protocol/api";

const capture = (cameras: number, frames: number | null, seconds: number | null): Capture => ({
  capture: "/captures/a",
  name: "a",
  layout: "N3DV",
  cameras: Array.from({ length: cameras }, (_, i) => `cam${i}`),
  frames,
  seconds,
  problem: null,
});

it.each([
  ["16 cameras · 60 frames · 2.0 s", capture(16, 60, 2)],
  ["1 camera · 1,200 frames · 40.0 s", capture(1, 1200, 40)],
  ["4 cameras", capture(4, null, null)],
  ["49 photographs of a still scene", capture(49, 1, 0)],
])("says %j", (words, described) => {
  expect(describeCapture(described)).toBe(words);
});
