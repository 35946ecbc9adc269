/** Views of a scene, and the depth and frustum for ordering splats in them. */

import { eyeOf, type Intrinsics, type Pose } from "../camera/pinhole";
import { add, length, scale, subtract } from "../camera/vector";
import type { CloseUp } from "../renderer/shot";
import { type SplatDepth, sameDepth } from "../worker/depth";
import { type Frustum, frustumOf, sameFrustum } from "../worker/frustum";

export interface View extends CloseUp {
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
    equal(a.pose.rotation, b.pose.rotation) &&
    equal(a.pose.translation, b.pose.translation)
  );
}

export interface Sight {
  readonly depth: SplatDepth;
  /** Null to order splats all around. */
  readonly frustum: Frustum | null;
}

/**
 * The sight of one view: its depth as in docs/numerics.md, and its frustum. For several views, as of a headset: the
 * distance from the middle of the eyes and no frustum, so that a head may turn without a new order.
 */
export function sightOf(views: readonly [View, ...View[]]): Sight {
  const [{ pose, camera }] = views;
  if (views.length > 1) return { depth: distance(views), frustum: null };
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

function distance(views: readonly View[]): SplatDepth {
  const eyes = views.map((view) => eyeOf(view.pose));
  const middle = scale(
    eyes.reduce((sum, eye) => add(sum, eye)),
    1 / eyes.length,
  );
  const apart = Math.max(...eyes.map((eye) => length(subtract(eye, middle))));
  // An eye may be nearer to a splat than the middle; the shader omits splats that are too near to it.
  const near = Math.max(0, Math.min(...views.map((view) => view.camera.near)) - apart);
  return { kind: "radial", x: middle[0], y: middle[1], z: middle[2], near };
}

const equal = (a: readonly number[], b: readonly number[]): boolean => a.every((value, i) => value === b[i]);
