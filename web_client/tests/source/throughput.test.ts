import { expect, it } from "vitest";
import { Throughput } from "../../src/source/throughput";

/** Count `bytes` every 50 ms, from one moment until another, milliseconds. */
function run(line: Throughput, bytes: number, from: number, until: number): void {
  for (let now = from; now <= until; now += 50) line.count(bytes, now);
}

it("tells what a steady line brings", () => {
  const line = new Throughput();
  run(line, 500, 0, 400);
  expect(line.rate(400)).toBeCloseTo(10_000);
});

it("does not know before anything was measured", () => {
  const line = new Throughput();
  expect(line.rate(0)).toBe(0);
  line.count(1e6, 0);
  expect(line.rate(1)).toBe(0);
});

it("notices soon that the line has become slower, and believes late that it has become faster", () => {
  const line = new Throughput();
  run(line, 5000, 0, 5000);
  run(line, 500, 5050, 6500);
  expect(line.rate(6500)).toBeLessThan(30_000); // of 100,000 before and 10,000 now
  run(line, 500, 6550, 30_000);
  run(line, 5000, 30_050, 31_500);
  expect(line.rate(31_500)).toBeLessThan(50_000);
});

it("does not take a line for slow that nothing was asked of", () => {
  const line = new Throughput();
  run(line, 500, 0, 400);
  expect(line.rate(60_000)).toBe(0);
  run(line, 500, 60_000, 60_400);
  expect(line.rate(60_400)).toBeCloseTo(10_000);
});
