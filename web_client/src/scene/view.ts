/** Views of a scene, and the depth and frustum for ordering splats in them. */

import type { Intrinsics, Pose } from "../camera/pinhole";
import type { Fading } from "../renderer/shot";
import { type SplatDepth, sameDepth } from "../worker/depth";
import { type Frustum, frustumOf, sameFrustum } from "../worker/frustum";

export interface View extends Fading {
  readonly pose: Pose;
  readonly camera: Intrinsics;
}

/** True if both views give the same picture. */
export function sameView(a: View | null, b: View): boolean {
  if (a === null) return false;
  const p = a.camera;
  const q = b.camera;
  return (
    p.width === q.width &&
    p.height === q.height &&
    p.fx === q.fx &&
    p.fy === q.fy &&
    p.cx === q.cx &&
    p.cy === q.cy &&
    p.near === q.near &&
    a.clear === b.clear &&
    a.still === b.still &&
    equal(a.pose.rotation, b.pose.rotation) &&
    equal(a.pose.translation, b.pose.translation)
  );
}

export interface Sight {
  readonly depth: SplatDepth;
  /** Null to order splats all around. */
  readonly frustum: Frustum | null;
}

/** The sight of a first view: its depth as in docs/numerics.md, and its frustum. */
export function sightOf([{ pose, camera }]: readonly [View, ...View[]]): Sight {
  const r = pose.rotation;
  const depth: SplatDepth = {
    kind: "planar",
    x: r[6],
    y: r[7],
    z: r[8],
    offset: pose.translation[2],
    near: camera.near,
  };
  return { depth, frustum: frustumOf(pose, camera) };
}

export const sameSight = (a: Sight, b: Sight): boolean =>
  sameDepth(a.depth, b.depth) && sameFrustum(a.frustum, b.frustum);

const equal = (a: readonly number[], b: readonly number[]): boolean => a.every((value, i) => value === b[i]);
