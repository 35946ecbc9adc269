import { expect, it } from "vitest";
import { type Intrinsics, poseAt } from "../../src/camera/pinhole";
import { cross, fromRows, length, normalise, subtract, type Vec3 } from "../../src/camera/vector";
import { type CropView, seenAt } from "../../src/crop/crop_view";
import { axisFor, middleOf } from "../../src/keyframes/aim";
import type { Viewing } from "../../src/player/viewpoint";

/** A picture with its axis aside and above the middle. */
const CAMERA: Intrinsics = { width: 800, height: 600, fx: 500, fy: 510, cx: 430, cy: 210, near: 0.2 };

function viewOf({ position, target, up }: Viewing): CropView {
  const ahead = normalise(subtract(target, position));
  const right = normalise(cross(ahead, up));
  return { pose: poseAt(position, fromRows(right, cross(ahead, right), ahead)), camera: CAMERA, eye: position };
}

const VIEWING: Viewing = { position: [1, -2, -5], target: [0.3, 0.2, 0.5], up: [0, -1, 0] };

it("finds the point in the middle of the picture, at the target's distance", () => {
  const middle = middleOf(VIEWING, viewOf(VIEWING));
  const [x, y] = seenAt(middle, viewOf(VIEWING)) as readonly [number, number];
  expect(x).toBeCloseTo(400, 9);
  expect(y).toBeCloseTo(300, 9);
  const far = (point: Vec3) => length(subtract(point, VIEWING.position));
  expect(far(middle)).toBeCloseTo(far(VIEWING.target), 9);
});

it("aims the axis so that a point is in the middle, which takes the middle back", () => {
  const middle = middleOf(VIEWING, viewOf(VIEWING));
  const found = axisFor({ ...VIEWING, target: middle }, viewOf);
  expect(length(subtract(found.target, VIEWING.target))).toBeLessThan(1e-4);
});
