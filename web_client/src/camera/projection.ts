/** Projection matrices of graphics libraries, converted to intrinsics. */

import type { Intrinsics } from "./pinhole";

/** A part of a framebuffer, in its pixels; (x, y) is the lower left corner. */
export interface Viewport {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/**
 * The intrinsics of a camera with a picture that fills a viewport, exact for any off-centre frustum.
 *
 * @param projection to clip space, 4 by 4, by columns, as in WebXR and three.js.
 * @param near world units
 */
export function projectedIntrinsics(
  projection: ArrayLike<number>,
  { width, height }: Pick<Viewport, "width" | "height">,
  near: number,
): Intrinsics {
  return {
    width,
    height,
    fx: (projection[0] * width) / 2,
    fy: (projection[5] * height) / 2,
    cx: ((1 - projection[8]) * width) / 2,
    cy: ((1 + projection[9]) * height) / 2,
    near,
  };
}
