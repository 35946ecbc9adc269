/** Where in the scene the viewer stands at first, and how large the scene is around them. */

import { eyeOf, type Pose } from "../camera/pinhole";
import { add, apply, cross, dot, length, normalise, row, scale, subtract, type Vec3 } from "../camera/vector";
import type { Manifest } from "../codec/types";
import type { RoomPose } from "./eye_camera";
import { compose, motion, type Similarity, transpose, yawOf } from "./similarity";

/** Eyes above the floor, metres: of a person who stands. */
export const EYE_HEIGHT = 1.6;

/** How far from what they capture people put their cameras, metres: it makes people in the scene as large as people. */
const CAPTURE_DISTANCE = 2.5;

type Size = Pick<Manifest, "extent" | "metresPerUnit">;

/** World units to a metre: as the scene says; else guessed from how far from its centre the cameras stood. */
export const unitsPerMetre = ({ extent, metresPerUnit }: Size): number =>
  metresPerUnit === null ? extent / CAPTURE_DISTANCE : 1 / metresPerUnit;

/**
 * The scene from the room, so that somebody at the room's origin, whose eyes are `eyeHeight` metres above it, looks from
 * where the camera `start` stood and to where it looked, with the scene's vertical upright.
 */
export function standingPlace(start: Pose, manifest: Size & Pick<Manifest, "up">, eyeHeight: number): Similarity {
  const { up } = manifest;
  const forward = horizontal(row(start.rotation, 2), up, row(start.rotation, 1));
  const units = unitsPerMetre(manifest);
  const right = cross(forward, up);
  const rotation = transpose([...right, ...up, ...scale(forward, -1)]);
  const eyes = scale(apply(rotation, [0, eyeHeight, 0]), units);
  return { rotation, scale: units, translation: subtract(eyeOf(start), eyes) };
}

/** The level part of `forward`; for a camera that looks straight down or up, of what is at the top of its picture. */
function horizontal(forward: Vec3, up: Vec3, down: Vec3): Vec3 {
  const flat = (v: Vec3): Vec3 => add(v, scale(up, -dot(v, up)));
  const level = flat(forward);
  if (length(level) > 1e-3) return normalise(level);
  const topwards = dot(forward, up) > 0 ? down : scale(down, -1); // looking up, the top of the picture is behind
  return normalise(flat(topwards));
}

/** The place `first` for somebody whose head is at `head` in the room by now: it is where they stand and look. */
export function standingHere(first: Similarity, { position: [x, , z], rotation }: RoomPose): Similarity {
  return compose(first, motion(-yawOf(rotation), 1, [x, 0, z], [0, 0, 0]));
}
