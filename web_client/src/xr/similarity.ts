/**
 * Similarities between the room, which WebXR measures in metres (x right, y up, z backwards), and the scene: rotation,
 * scale and shift. The rotation is always a proper one, so nothing is ever mirrored.
 */

import { add, apply, type Mat3, row, scale, subtract, type Vec3 } from "../camera/vector";

/** The map q = `scale` `rotation` p + `translation`; the rotation is row-major, with determinant 1. */
export interface Similarity {
  readonly rotation: Mat3;
  readonly scale: number;
  readonly translation: Vec3;
}

export const transpose = (m: Mat3): Mat3 => [m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]];

/** a b */
export function multiply(a: Mat3, b: Mat3): Mat3 {
  const columns = transpose(b);
  const rows = [0, 1, 2].map((i) => apply(columns, row(a, i as 0 | 1 | 2)));
  return rows.flat() as unknown as Mat3;
}

/** The rotation of a unit quaternion. */
export function rotationOf({ x, y, z, w }: { x: number; y: number; z: number; w: number }): Mat3 {
  // biome-ignore format: a matrix
  return [
    1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
    2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
    2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
  ];
}

/** A rotation about the room's vertical, counter-clockwise seen from above; radians. */
export function yawRotation(angle: number): Mat3 {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return [c, 0, s, 0, 1, 0, -s, 0, c];
}

/** The angle of a rotation about the room's vertical; radians. */
export const yawOf = (m: Mat3): number => Math.atan2(m[2] - m[6], m[0] + m[8]);

export const transformed = (s: Similarity, p: Vec3): Vec3 => add(scale(apply(s.rotation, p), s.scale), s.translation);

/** The similarity of first `b`, then `a`. */
export function compose(a: Similarity, b: Similarity): Similarity {
  return {
    rotation: multiply(a.rotation, b.rotation),
    scale: a.scale * b.scale,
    translation: transformed(a, b.translation),
  };
}

export function inverse({ rotation, scale: factor, translation }: Similarity): Similarity {
  const back = transpose(rotation);
  return { rotation: back, scale: 1 / factor, translation: scale(apply(back, translation), -1 / factor) };
}

/** The motion of the room that turns by `angle` about the vertical, scales, and moves the point `from` to `to`. */
export function motion(angle: number, factor: number, from: Vec3, to: Vec3): Similarity {
  const rotation = yawRotation(angle);
  return { rotation, scale: factor, translation: subtract(to, scale(apply(rotation, from), factor)) };
}
