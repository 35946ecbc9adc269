/** The viewer's first place in the scene, the scale of the scene around them, and the headset's frame of reference. */

import { eyeOf, type Pose } from "../camera/pinhole";
import { add, apply, cross, dot, length, normalise, row, scale, subtract, type Vec3 } from "../camera/vector";
import type { Manifest } from "../codec/types";
import type { RoomPose } from "./eye_camera";
import { compose, motion, type Similarity, transpose, yawOf } from "./similarity";

/** Height of a standing person's eyes above the floor, metres. */
export const EYE_HEIGHT = 1.6;

/** Usual distance of cameras from their subject, metres: with it, people in the scene are about life-size. */
const CAPTURE_DISTANCE = 2.5;

type Size = Pick<Manifest, "extent" | "metresPerUnit">;

/** World units to a metre: from the manifest, or else estimated from the distance of the cameras from the centre. */
export const unitsPerMetre = ({ extent, metresPerUnit }: Size): number =>
  metresPerUnit === null ? extent / CAPTURE_DISTANCE : 1 / metresPerUnit;

/**
 * The scene from the room for somebody at the room's origin, with eyes `eyeHeight` metres above it: the view of the
 * camera `start`, with the scene's vertical upright.
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

/** The level part of `forward`; for a camera that looks straight down or up, that of the upper edge of its picture. */
function horizontal(forward: Vec3, up: Vec3, down: Vec3): Vec3 {
  const flat = (v: Vec3): Vec3 => add(v, scale(up, -dot(v, up)));
  const level = flat(forward);
  if (length(level) > 1e-3) return normalise(level);
  const topwards = dot(forward, up) > 0 ? down : scale(down, -1); // looking up, the top of the picture is behind
  return normalise(flat(topwards));
}

/** The place `first`, moved to the position and the direction of a head in the room. */
export function standingHere(first: Similarity, { position: [x, , z], rotation }: RoomPose): Similarity {
  return compose(first, motion(-yawOf(rotation), 1, [x, 0, z], [0, 0, 0]));
}

export interface HeadsetSpace {
  readonly space: XRReferenceSpace;
  /** Height of a standing person's eyes above the space's origin, metres. */
  readonly eyeHeight: number;
}

/**
 * Kinds of spaces, best first: with the floor at height 0 if the headset detects it, else around the present head, as
 * for a seated person.
 */
const KINDS: readonly (readonly [XRReferenceSpaceType, number])[] = [
  ["local-floor", EYE_HEIGHT],
  ["bounded-floor", EYE_HEIGHT],
  ["local", 0],
];

/**
 * Request a space.
 *
 * @throws DOMException if the session offers none.
 */
export async function requestSpace(session: XRSession): Promise<HeadsetSpace> {
  let refusal: unknown;
  for (const [kind, eyeHeight] of KINDS) {
    try {
      return { space: await session.requestReferenceSpace(kind), eyeHeight };
    } catch (error) {
      refusal = error;
    }
  }
  throw refusal;
}
