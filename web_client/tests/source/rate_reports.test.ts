import { expect, it, vi } from "vitest";
import { RateReports } from "../../src/source/rate_reports";

/** A line that brings `bytes` every 50 ms, so often. */
function run(reports: RateReports, from: number, times: number, bytes: number): number {
  for (let k = 1; k <= times; k++) reports.count(bytes, from + 50 * k);
  return from + 50 * times;
}

it("tells how fast the line is, and again when that has changed, but not all the time", () => {
  const told: number[] = [];
  const reports = new RateReports(() => told.push(reports.rate));
  expect(reports.rate).toBe(0);
  const now = run(reports, 0, 60, 500);
  expect(told).toEqual([10_000]);
  run(reports, now, 60, 100);
  expect(told.at(-1)).toBeLessThan(4000);
  expect(told.length).toBeLessThan(5);
});

it("tells another server anew", () => {
  const tell = vi.fn();
  const reports = new RateReports(tell);
  const now = run(reports, 0, 60, 500);
  reports.forget();
  expect(reports.rate).toBe(0);
  run(reports, now, 60, 500);
  expect(reports.rate).toBe(10_000);
  expect(tell).toHaveBeenCalledTimes(2);
});
