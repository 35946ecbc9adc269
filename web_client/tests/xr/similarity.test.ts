import { describe, expect, it } from "vitest";
import type { Vec3 } from "../../src/camera/vector";
import {
  compose,
  inverse,
  motion,
  multiply,
  rotationOf,
  type Similarity,
  transformed,
  yawOf,
  yawRotation,
} from "../../src/xr/similarity";

const close = (a: Vec3, b: Vec3) => {
  for (const i of [0, 1, 2]) expect(a[i]).toBeCloseTo(b[i], 10);
};

const half = Math.SQRT1_2;
const tilted: Similarity = {
  rotation: multiply(yawRotation(0.7), rotationOf({ x: half, y: 0, z: 0, w: half })),
  scale: 2.5,
  translation: [1, -2, 3],
};

describe("similarity", () => {
  it("turns as the quaternion says: a quarter turn about x takes y to z", () => {
    const quarter = {
      rotation: rotationOf({ x: half, y: 0, z: 0, w: half }),
      scale: 1,
      translation: [0, 0, 0],
    } as const;
    close(transformed(quarter, [0, 1, 0]), [0, 0, 1]);
  });

  it("turns to the left by a positive yaw: what was ahead is on the left", () => {
    close(transformed(motion(Math.PI / 2, 1, [0, 0, 0], [0, 0, 0]), [0, 0, -1]), [-1, 0, 0]);
    expect(yawOf(yawRotation(0.3))).toBeCloseTo(0.3, 12);
  });

  it("is undone by its inverse", () => {
    close(transformed(inverse(tilted), transformed(tilted, [0.3, 0.4, 0.5])), [0.3, 0.4, 0.5]);
  });

  it("composes from the right to the left", () => {
    const moved = motion(0.4, 3, [1, 0, 0], [0, 1, 0]);
    close(transformed(compose(tilted, moved), [1, 2, 3]), transformed(tilted, transformed(moved, [1, 2, 3])));
  });

  it("moves the one point to the other", () => {
    close(transformed(motion(0.4, 3, [1, 2, 3], [4, 5, 6]), [1, 2, 3]), [4, 5, 6]);
  });
});
