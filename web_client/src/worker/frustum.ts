/** The frustum of a picture: keeps splats with an ellipse (docs/numerics.md, Projection) that may touch the screen. */

import type { Intrinsics, Pose } from "../camera/pinhole";
import { LOW_PASS } from "../renderer/layout";

/**
 * One side of a picture in the world. A splat with centre p may be visible if x p.x + y p.y + z p.z + offset + spread *
 * reach is not negative, where its reach is the radius of its visible part, world units.
 */
export interface Side {
  readonly x: number;
  readonly y: number;
  readonly z: number;
  readonly offset: number;
  readonly spread: number;
}

export type Frustum = readonly Side[];

/** Margin around the picture, relative to its size: an order is a frame or two behind a camera that turns. */
const SLACK = 0.1;
/** Deviations from the centre at which the most opaque splat falls to 1/255. */
const FARTHEST = Math.sqrt(2 * Math.log(255));
/** Deviation of the low-pass, pixels. */
const BLUR = Math.sqrt(LOW_PASS);
/** Distance from the picture, relative to its size, beyond which the projection's derivative stays constant. */
const CLAMP = 0.15;

/** Radius of a splat's visible part at its largest opacity, world units; negative if it is never visible. */
export function reachOf(opacity: number, logScaleX: number, logScaleY: number, logScaleZ: number): number {
  if (255 * opacity < 1) return -1;
  return Math.sqrt(2 * Math.log(255 * opacity)) * Math.exp(Math.max(logScaleX, logScaleY, logScaleZ));
}

/** The four sides of a picture; for splats before the camera. */
export function frustumOf({ rotation: r, translation: t }: Pose, camera: Intrinsics, slack = SLACK): Frustum {
  const { width, height, fx, fy, cx, cy } = camera;
  /**
   * The side along the row of the rotation at `row`, towards `sign`; the border is `pixels` from the principal point.
   */
  const side = (row: 0 | 3, sign: 1 | -1, pixels: number, size: number, focal: number): Side => {
    const tangent = (pixels + FARTHEST * BLUR + slack * size) / focal;
    // |jx| of a splat's longest axis is at most this times focal / depth.
    const steepest = (Math.max(pixels, size - pixels) + CLAMP * size) / focal;
    const [x, y, z] = [0, 1, 2].map((i) => sign * r[row + i] + tangent * r[6 + i]);
    const offset = sign * t[row === 0 ? 0 : 1] + tangent * t[2];
    return { x, y, z, offset, spread: Math.sqrt(1 + steepest * steepest) };
  };
  return [
    side(0, 1, cx, width, fx),
    side(0, -1, width - cx, width, fx),
    side(3, 1, cy, height, fy),
    side(3, -1, height - cy, height, fy),
  ];
}

/** True if both keep the same splats. */
export function sameFrustum(a: Frustum | null, b: Frustum | null): boolean {
  if (a === null || b === null) return a === b;
  return a.every((side, i) => {
    const other = b[i];
    return (
      side.x === other.x &&
      side.y === other.y &&
      side.z === other.z &&
      side.offset === other.offset &&
      side.spread === other.spread
    );
  });
}

/** Whether a splat of that reach at (x, y, z) may be visible. */
export function mayShow(frustum: Frustum, x: number, y: number, z: number, reach: number): boolean {
  for (let i = 0; i < frustum.length; i++) {
    const side = frustum[i];
    if (side.x * x + side.y * y + side.z * z + side.offset + side.spread * reach < 0) return false;
  }
  return true;
}
