/** From where a scene is seen: a pose and intrinsics in pixels of the canvas's backing store. */

import type { Intrinsics, Pose } from "../camera/pinhole";

export interface View {
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
    a.pose.rotation.every((value, i) => value === b.pose.rotation[i]) &&
    a.pose.translation.every((value, i) => value === b.pose.translation[i])
  );
}
