import { expect, it } from "vitest";
import { poseAt, project } from "../../src/camera/pinhole";
import { projectedIntrinsics } from "../../src/camera/projection";
import { frustum } from "../frustum";

/** Where WebGL's pipeline puts a point before a camera at the origin: pixels from the top left. */
function clipped(m: Float32Array, [x, y, z]: readonly [number, number, number], width: number, height: number) {
  const [u, v, , w] = [0, 1, 2, 3].map((i) => m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i]);
  return [((u / w + 1) / 2) * width, ((1 - v / w) / 2) * height];
}

it.each([
  [0, 0, -1],
  [0.4, -0.3, -2],
  [-1, 0.2, -3],
] as const)("puts the point %s %s %s where a lopsided projection puts it", (...point) => {
  const projection = frustum(-0.12, 0.07, -0.09, 0.05);
  const camera = projectedIntrinsics(projection, { width: 300, height: 400 }, 0.05);
  const [x, y, depth] = project(point, poseAt([0, 0, 0], [1, 0, 0, 0, -1, 0, 0, 0, -1]), camera);
  const [u, v] = clipped(projection, point, 300, 400);
  expect(x).toBeCloseTo(u, 4);
  expect(y).toBeCloseTo(v, 4);
  expect(depth).toBeCloseTo(-point[2], 10);
});
