/**
 * The middle of a picture, which the optical axis does not go through where a window cuts the picture off unevenly. Camera
 * paths aim the middle, the player's camera its axis.
 */

import { add, length, normalise, scale, subtract, type Vec3 } from "../camera/vector";
import { type CropView, rayThrough } from "../crop/crop_view";
import type { Viewing } from "../player/viewpoint";

/** Steps of `axisFor`; each leaves a small share of the error. */
const STEPS = 12;

/** The point in the middle of a picture at the target's distance. */
export function middleOf({ position, target }: Viewing, view: CropView): Vec3 {
  return add(position, scale(middleRay(view), length(subtract(target, position))));
}

/**
 * The viewing with a point in the middle of its picture.
 *
 * @param viewOf the view of a viewing; null where it has none.
 */
export function axisFor({ position, target, up }: Viewing, viewOf: (viewing: Viewing) => CropView | null): Viewing {
  const distance = length(subtract(target, position));
  const wanted = normalise(subtract(target, position));
  let axis = wanted;
  for (let step = 0; step < STEPS; step++) {
    const view = viewOf({ position, target: add(position, axis), up });
    if (!view) break;
    axis = normalise(add(axis, subtract(wanted, middleRay(view))));
  }
  return { position, target: add(position, scale(axis, distance)), up };
}

const middleRay = (view: CropView): Vec3 => rayThrough([view.camera.width / 2, view.camera.height / 2], view);
