/** What one picture shows, and what a picture that was read back holds. */

import type { Rig } from "../camera/magnification";
import type { Intrinsics, Pose } from "../camera/pinhole";

/** What becomes of splats that an eye comes close to; for eyes that go anywhere: moved by a visitor, or in a headset. */
export interface CloseUp {
  /** Depth from which on splats are drawn in full, world units; towards the near plane they fade. Left out, none does. */
  readonly clear?: number;
  /** Standard deviation, pixels, from which on a splat fades; one twice as wide is not drawn. Left out, none is too wide. */
  readonly widest?: number;
}

/** With nothing of `CloseUp` it is the picture of docs/numerics.md. */
export interface Shot extends CloseUp {
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
  /** Where this picture is larger than theirs, splats are as soft as in theirs. */
  readonly rig: Rig;
}

/** Rows from the top, RGBA; bytes from the canvas, floats (linear in the same units, 0 to 1) from the float target. */
export interface Pixels {
  readonly width: number;
  readonly height: number;
  readonly data: Uint8Array | Float32Array;
}
