/** What one picture shows, and what a picture that was read back holds. */

import type { Intrinsics, Pose } from "../camera/pinhole";

export interface Shot {
  readonly pose: Pose;
  readonly camera: Intrinsics;
  /** Normalised time of the segment whose dynamics the order names. */
  readonly time: number;
  /**
   * Fade splats thinner than the low-pass, which else show too wide and too strong from afar (docs/numerics.md,
   * "Antialiasing"). On a page the player decides; pictures for the eyes of a headset always set it, or thin splats
   * shimmer as the head moves. A scene that was trained without it looks fainter so.
   */
  readonly antialiased: boolean;
}

/** Rows from the top, RGBA; bytes from the canvas, floats (linear in the same units, 0 to 1) from the float target. */
export interface Pixels {
  readonly width: number;
  readonly height: number;
  readonly data: Uint8Array | Float32Array;
}
