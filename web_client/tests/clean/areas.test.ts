import { describe, expect, it } from "vitest";
import { boxArea, strokeArea } from "../../src/clean/areas";

describe("a box", () => {
  it("holds what is between its corners, drawn in any direction", () => {
    for (const area of [boxArea([10, 20], [30, 60]), boxArea([30, 60], [10, 20]), boxArea([10, 60], [30, 20])]) {
      expect(area.box).toEqual([10, 20, 30, 60]);
      expect(area.contains(10, 60)).toBe(true);
      expect(area.contains(9, 40)).toBe(false);
      expect(area.contains(20, 61)).toBe(false);
    }
  });
});

describe("a stroke", () => {
  it("holds what is within its radius of the line, corners of its box not", () => {
    const area = strokeArea(
      [
        [0, 0],
        [100, 0],
        [100, 50],
      ],
      10,
    );
    expect(area.box).toEqual([-10, -10, 110, 60]);
    expect(area.contains(50, 9)).toBe(true);
    expect(area.contains(50, 11)).toBe(false);
    expect(area.contains(91, 30)).toBe(true);
    expect(area.contains(-8, -8)).toBe(false);
  });

  it("of one point is a circle", () => {
    const area = strokeArea([[5, 5]], 3);
    expect(area.contains(7, 7)).toBe(true);
    expect(area.contains(7.5, 7.5)).toBe(false);
  });
});
