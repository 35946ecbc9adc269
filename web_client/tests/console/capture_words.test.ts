import { expect, it } from "vitest";
import { describeCapture, priceWords } from "../../src/console/submit_page";
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

it.each([
  ["about 21 minutes here · at most 1.4 MB", { minutes: 20.6, bytes: 1_430_000 }],
  ["about 1 minute here · at most 90 KB", { minutes: 0.2, bytes: 90_000 }],
  ["about 3 hours here · at most 5.5 MB", { minutes: 170, bytes: 5_480_000 }],
  ["", undefined],
])("says %j of a price", (words, price) => {
  expect(priceWords(price)).toBe(words);
});
