import { expect, it } from "vitest";
import type { Quality } from "../../src/renderer/fineness";
import { LADDER } from "../../src/renderer/fineness";
import { figuresOf, formatBitRate, formatCount } from "../../src/ui/stats_panel";
import { stats } from "../stats";

const figure = (name: string, fields: Parameters<typeof stats>[0], quality: Quality = "auto") =>
  figuresOf(stats(fields), { width: 640, height: 480, quality })[name];

it.each([
  [59.94, "59.9"],
  [0.4, "0.40"],
  [0, "at rest"],
])("writes %s frames per second as %s", (framesPerSecond, text) => {
  expect(figure("Frames/s", { framesPerSecond })).toBe(text);
});

it("tells how old the order is, how long it took, what was dropped and how fast the line is", () => {
  expect(figure("Order age", {})).toBe("16 ms");
  expect(figure("Sort time", {})).toBe("1.3 ms");
  expect(figure("Dropped frames", {})).toBe("10 of 100");
  expect(figure("Line rate", {})).toBe("2.0 Mbit/s");
});

it.each([
  ["Order age", { framesPerSecond: 0, orderAge: 6683 }],
  ["Line rate", { lineRate: 0 }],
  ["Sort time", { splats: 0, sortTime: 0 }],
  ["Dropped frames", { framesDrawn: 0, framesDropped: 0 }],
  ["First picture", { firstFrame: null }],
])("writes no figure for %s where it means nothing", (name, fields) => {
  expect(figure(name, fields)).toBe("–");
});

it("counts the first picture from when its scene began to be loaded", () => {
  expect(figure("First picture", { firstFrame: 33_500, loadStart: 32_700 })).toBe("0.80 s");
});

it("calls the stream of a complete scene complete, and no other", () => {
  expect(figure("Stream", { complete: true, stream: "closed" })).toBe("complete");
  expect(figure("Stream", { stream: "closed" })).toBe("closed");
});

it.each([true, false])(
  "says that a scene comes over HTTP for want of WebSockets, also when all of it is here: %s",
  (complete) => {
    expect(figure("Stream", { complete, stream: "over-http" })).toBe("HTTP: no WebSockets here");
  },
);

it("tells how finely the picture is to be drawn, and how finely it was", () => {
  expect(figure("Quality", {})).toBe("auto");
  expect(figure("Quality", {}, "low")).toBe("always low");
  expect(figure("Drawn at", {})).toBe("640 × 480, half floats");
  expect(figure("Drawn at", { fineness: LADDER[3] })).toBe("320 × 240, 8 bits");
});

it.each([
  [0, "0 kbit/s"],
  [64_000, "512 kbit/s"],
  [124_990, "1.0 Mbit/s"],
  [237_500, "1.9 Mbit/s"],
])("writes %s bytes per second as %s", (rate, text) => {
  expect(formatBitRate(rate)).toBe(text);
});

it.each([
  [950, "950"],
  [12_400, "12.4k"],
  [152_746, "153k"],
  [999_600, "1.0M"],
])("writes %s splats as %s", (count, text) => {
  expect(formatCount(count)).toBe(text);
});
