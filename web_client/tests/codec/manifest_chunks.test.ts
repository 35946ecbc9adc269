import { describe, expect, it } from "vitest";
import { chunksOf, layersOf, sliceAt } from "../../src/codec/manifest_chunks";
import { entry, manifest, slice } from "../scene";

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

it("takes the shortest beginning with a fourth of what stands, or a third of a slice, for its base", () => {
  const scene = manifest({
    static: ["a", "b", "c", "d", "e"].map((id) => entry(id)),
    slices: [slice(0, 1, ["f", "g", "h"]), slice(1, 2, ["i", "j", "k", "l"], ["f", "h"])],
  });
  const layers = Object.fromEntries([...layersOf(scene)].map(([id, { layer }]) => [id, layer]));
  expect(layers).toEqual({ a: 0, b: 0, c: 1, d: 2, e: 3, f: 0, g: 1, h: 2, i: 0, j: 0, k: 1, l: 2 });
});
