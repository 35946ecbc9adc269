/** The sight of a head: one order of splats for both eyes. */

import { eyeOf } from "../camera/pinhole";
import { add, length, scale, subtract } from "../camera/vector";
import { type Sight, sightOf, type View } from "./view";

/**
 * The sight of several views: the distance from the middle of the eyes and no frustum, so that a head may turn without a
 * new order. For one view `sightOf`.
 */
export function headSight(views: readonly [View, ...View[]]): Sight {
  if (views.length === 1) return sightOf(views);
  const eyes = views.map((view) => eyeOf(view.pose));
  const [x, y, z] = scale(
    eyes.reduce((sum, eye) => add(sum, eye)),
    1 / eyes.length,
  );
  const apart = Math.max(...eyes.map((eye) => length(subtract(eye, [x, y, z]))));
  // An eye may be nearer to a splat than the middle; the shader omits splats that are too near to it.
  const near = Math.max(0, Math.min(...views.map((view) => view.camera.near)) - apart);
  return { depth: { kind: "radial", x, y, z, near }, frustum: null };
}
