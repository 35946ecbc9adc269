import { expect, it } from "vitest";
import { formatBytes, formatDuration, formatTime } from "../../src/dom/format";

it.each([
  [0, "0 B"],
  [999, "999 B"],
  [1000, "1.0 KB"],
  [61_234, "61 KB"],
  [1_340_000, "1.3 MB"],
  [2.5e12, "2.5 TB"],
])("writes %s bytes as %s", (bytes, text) => {
  expect(formatBytes(bytes)).toBe(text);
});

it.each([
  [1.98, "0:01.98"],
  [59.999, "1:00.00"],
  [725, "12:05.00"],
  [-1, "0:00.00"],
])("writes the position %s as %s", (seconds, text) => {
  expect(formatTime(seconds)).toBe(text);
});

it.each([
  [2, "2.0 s"],
  [65, "1 min 05 s"],
  [119.9, "2 min 00 s"],
])("writes the length %s as %s", (seconds, text) => {
  expect(formatDuration(seconds)).toBe(text);
});
