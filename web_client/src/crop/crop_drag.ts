/** Drags of a box's handles. */

import { add, cross, dot, length, normalise, row, scale, subtract, type Vec3 } from "../camera/vector";
import { type CropBox, type Face, middleOf, outwards, turned, withFaceMoved } from "./crop_box";
import { alongLine, type CropView, onPlane, type Pixel, rayThrough } from "./crop_view";

/** A handle: a face, the middle, or the turn. */
export type Handle = Face | "middle" | "turn";

/** Distance of the turn's handle from the middle of the box, in depths. */
export const TURN_REACH = 0.72;

/** The place of a handle in the world. */
export function placeOf(handle: Handle, box: CropBox): Vec3 {
  if (handle === "middle") return box.center;
  if (handle !== "turn") return middleOf(box, handle);
  const floor = add(box.center, scale(row(box.axes, 1), box.size[1] / 2));
  return add(floor, scale(row(box.axes, 2), -TURN_REACH * box.size[2]));
}

/**
 * The box after a drag of a handle from one place of the picture to another; unchanged if the drag defines no motion.
 */
export function dragged(handle: Handle, box: CropBox, from: Pixel, to: Pixel, view: CropView): CropBox {
  const place = placeOf(handle, box);
  if (handle === "turn") return turnedBy(box, place, from, to, view);
  if (handle === "middle") {
    const ahead = row(view.pose.rotation, 2);
    const [a, b] = [onPlane(place, ahead, from, view), onPlane(place, ahead, to, view)];
    return a && b ? { ...box, center: add(box.center, subtract(b, a)) } : box;
  }
  const direction = outwards(box, handle);
  const [a, b] = [alongLine(place, direction, from, view), alongLine(place, direction, to, view)];
  return a === null || b === null ? box : withFaceMoved(box, handle, b - a);
}

/** Sine of the smallest angle to the floor for a drag around it. */
const STEEP = 0.2;

/**
 * The angle of a turn about the upright axis: between the floor's points at both places, or, if the floor is seen
 * nearly from its edge, by the length of the drag along the handle's path.
 */
function turnedBy(box: CropBox, place: Vec3, from: Pixel, to: Pixel, view: CropView): CropBox {
  const up = scale(row(box.axes, 1), -1);
  const middle = add(box.center, scale(up, -box.size[1] / 2));
  if (Math.abs(dot(rayThrough(from, view), up)) > STEEP) {
    const [a, b] = [onPlane(place, up, from, view), onPlane(place, up, to, view)];
    if (!a || !b) return box;
    const [p, q] = [subtract(a, middle), subtract(b, middle)];
    return turned(box, Math.atan2(dot(up, cross(p, q)), dot(p, q)));
  }
  const arm = subtract(place, middle);
  const way = normalise(cross(up, arm));
  const [a, b] = [alongLine(place, way, from, view), alongLine(place, way, to, view)];
  return a === null || b === null ? box : turned(box, (b - a) / length(arm));
}
