/** How deep a splat lies: what an order is sorted by, and from where on splats are drawn. */

/**
 * Depth along the view axis, x p.x + y p.y + z p.z + offset: the order that docs/numerics.md states. Splats of less than
 * `near`, above 0, are not drawn.
 */
export interface PlanarDepth {
  readonly kind: "planar";
  readonly x: number;
  readonly y: number;
  readonly z: number;
  readonly offset: number;
  readonly near: number;
}

/**
 * Distance from the point (x, y, z), the middle of a head: one order for both eyes, wherever the head turns. Splats closer
 * than `near`, at least 0, are not drawn.
 */
export interface RadialDepth {
  readonly kind: "radial";
  readonly x: number;
  readonly y: number;
  readonly z: number;
  readonly near: number;
}

export type SplatDepth = PlanarDepth | RadialDepth;

/** True if both give every splat the same depth, and leave out the same ones. */
export function sameDepth(a: SplatDepth, b: SplatDepth): boolean {
  if (a.x !== b.x || a.y !== b.y || a.z !== b.z || a.near !== b.near) return false;
  return a.kind === "planar" ? b.kind === "planar" && a.offset === b.offset : b.kind === "radial";
}
