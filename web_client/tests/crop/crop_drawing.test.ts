import { describe, expect, it } from "vitest";
import { hull } from "../../src/crop/crop_drawing";

describe("the outline of a box", () => {
  it("is the convex hull of its corners, in order", () => {
    expect(
      hull([
        [0, 0],
        [2, 0],
        [1, 1],
        [2, 2],
        [0, 2],
        [1, 0.5],
      ]),
    ).toEqual([
      [0, 0],
      [2, 0],
      [2, 2],
      [0, 2],
    ]);
  });
});
