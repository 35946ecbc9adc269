import { expect, it } from "vitest";
import { LineRate } from "../../src/player/line_rate";

it("counts what came in the last second", () => {
  const line = new LineRate();
  line.count(1000, 0);
  line.count(2000, 600);
  line.count(3000, 1200);
  expect(line.rate(1200)).toBe(5000);
  expect(line.rate(1700)).toBe(3000);
  expect(line.rate(9000)).toBe(0);
});
