/** By which depth the splats are sorted for what is seen. */

import { eyeOf } from "../camera/pinhole";
import { add, length, scale, subtract } from "../camera/vector";
import type { SplatDepth } from "../worker/depth";
import type { View } from "./view";

/** One view: the depth that docs/numerics.md states. Several, as of a headset: their distance from the middle of the eyes. */
export function depthOf(views: readonly [View, ...View[]]): SplatDepth {
  const [{ pose, camera }] = views;
  if (views.length === 1) {
    const r = pose.rotation;
    return { kind: "planar", x: r[6], y: r[7], z: r[8], offset: pose.translation[2], near: camera.near };
  }
  const eyes = views.map((view) => eyeOf(view.pose));
  const middle = scale(
    eyes.reduce((sum, eye) => add(sum, eye)),
    1 / eyes.length,
  );
  const apart = Math.max(...eyes.map((eye) => length(subtract(eye, middle))));
  // An eye may be nearer to a splat than the middle is; what is too near to it the shader leaves out.
  const near = Math.max(0, Math.min(...views.map((view) => view.camera.near)) - apart);
  return { kind: "radial", x: middle[0], y: middle[1], z: middle[2], near };
}
