import { describe, expect, it } from "vitest";
import { chunksOf, sliceAt } from "../../src/codec/slices";
import { slice } from "../scene";

const slices = [slice(0, 0.5, ["a"]), slice(0.5, 1, ["b"], ["a"]), slice(1, 2, ["c", "d"])];

describe("sliceAt", () => {
  it.each([
    [-1, 0],
    [0, 0],
    [0.49, 0],
    [0.5, 1],
    [1.5, 2],
    [2, 2],
    [9, 2],
  ])("at %s shows slice %s", (time, index) => {
    expect(sliceAt(slices, time)).toBe(index);
  });

  it("finds none in a still scene", () => {
    expect(sliceAt([], 0)).toBe(-1);
  });
});

describe("chunksOf", () => {
  it("names the slice's own chunks and those of earlier slices that it needs", () => {
    expect(slices.map(chunksOf)).toEqual([["a"], ["a", "b"], ["c", "d"]]);
  });
});
