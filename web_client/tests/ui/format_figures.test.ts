import { expect, it } from "vitest";
import { formatBitRate, formatCount } from "../../src/ui/format_figures";

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
