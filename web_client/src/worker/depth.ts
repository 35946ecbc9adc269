/** The depth of splats: the key of an order, and the limit of drawing. */

/**
 * Depth along the view axis, x p.x + y p.y + z p.z + offset: the order of docs/numerics.md. Splats with a depth below
 * `near`, which is above 0, are not drawn.
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
 * Distance from the point (x, y, z), the middle of a head: one order for both eyes, for any turn of the head. Splats
 * closer than `near`, at least 0, are not drawn.
 */
export interface RadialDepth {
  readonly kind: "radial";
  readonly x: number;
  readonly y: number;
  readonly z: number;
  readonly near: number;
}

export type SplatDepth = PlanarDepth | RadialDepth;

/** True if both give every splat the same depth, and exclude the same ones. */
export function sameDepth(a: SplatDepth, b: SplatDepth): boolean {
  if (a.x !== b.x || a.y !== b.y || a.z !== b.z || a.near !== b.near) return false;
  return a.kind === "planar" ? b.kind === "planar" && a.offset === b.offset : b.kind === "radial";
}
