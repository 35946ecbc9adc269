/** How much larger a view shows things than the pictures that made a scene (docs/numerics.md, "Magnification"). */

import type { Manifest } from "../codec/types";
import { eyeOf, type Intrinsics, type Pose, poseOf } from "./pinhole";
import { add, apply, dot, length, row, scale, subtract, type Vec3 } from "./vector";

/** The cameras of the pictures that made a scene, with their focal lengths in pixels of those pictures; none if unknown. */
export type Rig = readonly (Pose & { readonly focal: number })[];

/** A factor below 1: rounding magnifies nothing in a picture that made the scene. */
const SLACK = 1 - 2 ** -12;
/** World units squared: a camera that stands and looks as the view does has all the weight. */
const TINY = 1e-300;

export function rigOf({ photographed, cameras }: Pick<Manifest, "photographed" | "cameras">): Rig {
  const listed = photographed ? cameras : [];
  return listed.map(({ worldToCamera, fx, fy }) => ({ ...poseOf(worldToCamera), focal: Math.max(fx, fy) }));
}

/**
 * a, b, c, d, so that a point (x, y, z) in the view shows (a x + b y + c z + d) / z times as large as the cameras of the
 * rig beside the view showed it; zeros without a rig.
 */
export function magnification(rig: Rig, pose: Pose, { fx, fy }: Intrinsics): [number, number, number, number] {
  const eye = eyeOf(pose);
  const away = rig.map((camera) => length(subtract(eyeOf(camera), eye)) ** 2);
  const farthest = Math.max(...away);
  const apart = rig.map(
    ({ rotation }, i) => away[i] + farthest * Math.max(0, 1 - dot(row(rotation, 2), row(pose.rotation, 2))) + TINY,
  );
  const nearest = Math.min(...apart);
  // World units per pixel at a point: the cameras' depths over their focal lengths, by weights.
  let [weights, shift] = [0, 0];
  let normal: Vec3 = [0, 0, 0];
  rig.forEach(({ rotation, translation, focal }, i) => {
    const weight = (nearest / apart[i]) ** 2;
    weights += weight;
    normal = add(normal, scale(row(rotation, 2), weight / focal));
    shift += (translation[2] * weight) / focal;
  });
  const pixels = (SLACK * Math.max(fx, fy)) / (weights || 1);
  const [a, b, c] = apply(pose.rotation, scale(normal, pixels));
  return [a, b, c, pixels * shift - dot([a, b, c], pose.translation)];
}
