import { describe, expect, it } from "vitest";
import { linePath, scaleOf } from "../../src/console/chart_scale";

describe("scaleOf", () => {
  it("holds the values between round ticks", () => {
    expect(scaleOf([17.2, 28.9], 4)).toEqual({ low: 15, high: 30, ticks: [15, 20, 25, 30] });
    expect(scaleOf([0.031, 0.3], 3)).toEqual({ low: 0, high: 0.3, ticks: [0, 0.1, 0.2, 0.3] });
    expect(scaleOf([-3, 7], 5).ticks).toEqual([-4, -2, 0, 2, 4, 6, 8]);
  });

  it("makes room around a single value", () => {
    const { low, high } = scaleOf([20, 20], 3);
    expect(low).toBeLessThan(20);
    expect(high).toBeGreaterThan(20);
    expect(scaleOf([0], 3).ticks.length).toBeGreaterThan(1);
  });

  it("is empty without values", () => {
    expect(scaleOf([], 4)).toEqual({ low: 0, high: 1, ticks: [] });
  });
});

describe("linePath", () => {
  it("draws from left to right, upwards", () => {
    const points = [
      [0, 10],
      [5, 20],
      [10, 15],
    ] as const;
    expect(linePath(points, { low: 0, high: 10 }, { low: 10, high: 20 }, 100, 50)).toBe(
      "M0.0 50.0L50.0 0.0L100.0 25.0",
    );
  });

  it("draws a dot of one point", () => {
    expect(linePath([[5, 1]], { low: 0, high: 10 }, { low: 0, high: 2 }, 10, 10)).toBe("M5.0 5.0h0");
  });

  it("draws nothing of nothing", () => {
    expect(linePath([], { low: 0, high: 1 }, { low: 0, high: 1 }, 10, 10)).toBe("");
  });
});
