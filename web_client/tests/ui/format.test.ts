import { expect, it } from "vitest";
import { formatBitRate, formatBytes, formatCount, formatDuration, formatTime } from "../../src/ui/format";

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
