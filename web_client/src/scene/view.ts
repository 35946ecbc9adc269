/** From where a scene is seen: a pose and intrinsics in pixels of the canvas's backing store. */

import type { Intrinsics, Pose } from "../camera/pinhole";
import type { CloseUp } from "../renderer/shot";

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

const equal = (a: readonly number[], b: readonly number[]): boolean => a.every((value, i) => value === b[i]);
