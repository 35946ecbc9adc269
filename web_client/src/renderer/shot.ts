/** A shot, which defines one picture, and the pixels of a picture. */

import type { Rig } from "../camera/magnification";
import type { Intrinsics, Pose } from "../camera/pinhole";

/** The fading of splats for eyes at any place, moved by a visitor or in a headset: close to it, or not filmed from there. */
export interface Fading {
  /** Smallest depth without fading, world units; splats fade towards the near plane. Undefined: 0. */
  readonly clear?: number;
  /** Largest standard deviation without fading, pixels; splats of twice that are not drawn. Undefined: unlimited. */
  readonly widest?: number;
  /** Factor of the opacity of static splats. Undefined: 1. */
  readonly still?: number;
}

/** A picture, that of docs/numerics.md unless something fades. */
export interface Shot extends Fading {
  readonly pose: Pose;
  readonly camera: Intrinsics;
  /** Normalised time in the segment of the order's dynamics. */
  readonly time: number;
  /**
   * Fade splats thinner than the low-pass, which otherwise appear too wide and too strong from afar (docs/numerics.md,
   * "Antialiasing"). On a page the player decides; a headset always sets it, because thin splats would shimmer as the
   * head moves. Scenes trained without it look fainter with it.
   */
  readonly antialiased: boolean;
  /** The cameras of the pictures that made the scene: a larger picture is as soft as theirs. */
  readonly rig: Rig;
}

/**
 * Pixels in RGBA, from the top row; bytes from the canvas, floats (linear in the same units, 0 to 1) from the float
 * target.
 */
export interface Pixels {
  readonly width: number;
  readonly height: number;
  readonly data: Uint8Array | Float32Array;
}
