import { expect, it } from "vitest";
import { layersOf } from "../../src/codec/layers";
import { entry, manifest, slice } from "../scene";

it("takes the shortest beginning with a fourth of what stands, or a third of a slice, for its base", () => {
  const scene = manifest({
    static: ["a", "b", "c", "d", "e"].map((id) => entry(id)),
    slices: [slice(0, 1, ["f", "g", "h"]), slice(1, 2, ["i", "j", "k", "l"], ["f", "h"])],
  });
  const layers = Object.fromEntries([...layersOf(scene)].map(([id, { layer }]) => [id, layer]));
  expect(layers).toEqual({ a: 0, b: 0, c: 1, d: 2, e: 3, f: 0, g: 1, h: 2, i: 0, j: 0, k: 1, l: 2 });
});
