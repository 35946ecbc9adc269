/**
 * Limits of an orbit camera: it moves freely in the captured space, against a rubber band beyond it, and springs back
 * when it is released (docs/format.md, "Captured space").
 *
 * All functions take null for an unknown space, which has no limits.
 */

import type { CapturedSpace } from "../codec/types";
import { azimuths, distances, elevations, type Range, type SeenLimits } from "./seen_limits";
import { add, cross, dot, length, rotateAbout, scale, subtract, type Vec3 } from "./vector";

/** The position of an eye relative to its target. */
export interface OrbitPose {
  /** Radians from the front, counter-clockwise seen from above. A long drag may exceed pi and -pi. */
  readonly azimuth: number;
  /** Radians above the horizon. */
  readonly elevation: number;
  /** World units, above 0. */
  readonly distance: number;
}

/** A captured space, with narrower limits if the document has them. */
export type Space = CapturedSpace & { readonly limits?: SeenLimits | null };

/** The frame of reference of an orbit pose. */
export interface OrbitFrame {
  /** The centre of the orbit. */
  readonly center: Vec3;
  /** Unit vector. */
  readonly up: Vec3;
  /** Unit vector at right angles to `up`. */
  readonly front: Vec3;
}

/** The most that the rubber band gives: radians, and the logarithm of a factor of the distance. */
const GIVE = { angle: 0.2, distance: Math.log(1.5) };
/** Speed of springing back: the rest of the way falls to 1 / e in this time, seconds. */
const SPRING = 0.12;
/** Share of the band's give at which a camera that springs back has arrived. */
const ARRIVED = 1e-3;

/** The pose of an eye; the azimuth is 0 straight above or below the centre. */
export function orbitPoseOf(eye: Vec3, { center, up, front }: OrbitFrame): OrbitPose {
  const offset = subtract(eye, center);
  const ahead = dot(offset, front);
  const aside = dot(offset, cross(up, front));
  return {
    azimuth: Math.atan2(aside, ahead),
    elevation: Math.atan2(dot(offset, up), Math.hypot(ahead, aside)),
    distance: length(offset),
  };
}

/** The position of a pose's eye. */
export function eyeAt(pose: OrbitPose, { center, up, front }: OrbitFrame): Vec3 {
  const ahead = rotateAbout(front, up, pose.azimuth);
  const direction = add(scale(ahead, Math.cos(pose.elevation)), scale(up, Math.sin(pose.elevation)));
  return add(center, scale(direction, pose.distance));
}

/** Whether a pose is in the captured space. */
export function isInside({ azimuth, elevation, distance }: OrbitPose, space: Space | null): boolean {
  return (
    !space ||
    (within(azimuth, azimuths(space)) &&
      within(elevation, elevations(space, azimuth)) &&
      within(distance, distances(space, azimuth, elevation)))
  );
}

/**
 * The displayed pose for the pose of a drag: the same inside, and beyond the border ever less beyond, up to the band's
 * give.
 *
 * Keep the drag's pose while it lasts and display this one: limiting a displayed pose would pull twice. A drag that
 * begins while the camera springs back begins at `unlimited` of the displayed pose, so that the picture does not jump.
 */
export function limited(asked: OrbitPose, space: Space | null): OrbitPose {
  return space ? mapped(asked, space, stretched) : asked;
}

/** The inverse of `limited`, up to the band's give. */
export function unlimited(shown: OrbitPose, space: Space | null): OrbitPose {
  return space ? mapped(shown, space, unstretched) : shown;
}

/**
 * The nearest pose inside, in azimuth, then in elevation, then in distance: the rest position of a released camera.
 */
export function nearestInside(pose: OrbitPose, space: Space | null): OrbitPose {
  return space ? mapped(pose, space, () => 0) : pose;
}

/**
 * The pose of a camera `seconds` after its release at `shown`: on its way to `nearestInside`, in the end exactly there.
 */
export function springBack(shown: OrbitPose, space: Space | null, seconds: number): OrbitPose {
  const left = Math.exp(-seconds / SPRING);
  return space ? mapped(shown, space, (beyond, give) => (beyond > ARRIVED * give ? beyond * left : 0)) : shown;
}

/** Map of the distance beyond a border, at least 0, for a largest give. */
type Beyond = (beyond: number, give: number) => number;

/** Slope 1 at the border, so that the band begins smoothly; `give` far away. */
const stretched: Beyond = (beyond, give) => (beyond * give) / (beyond + give);

/** A number at the band's end or past it counts as near the end: nothing maps to it. */
const unstretched: Beyond = (beyond, give) => {
  const share = Math.min(beyond / give, 1 - ARRIVED);
  return (share / (1 - share)) * give;
};

/** Limits of a pose beyond the border: those of the border beside it, so that `limited` keeps them. */
function mapped({ azimuth, elevation, distance }: OrbitPose, space: Space, map: Beyond): OrbitPose {
  const across = azimuths(space);
  const beside = moved(azimuth, across, () => 0);
  const upward = elevations(space, beside);
  const outward = distances(
    space,
    beside,
    moved(elevation, upward, () => 0),
  );
  return {
    azimuth: moved(azimuth, across, map),
    elevation: moved(elevation, upward, map),
    distance: zoomed(distance, outward, map),
  };
}

function zoomed(value: number, [nearest, farthest]: Range, map: Beyond): number {
  if (value > farthest) return farthest * Math.exp(map(Math.log(value / farthest), GIVE.distance));
  if (value < nearest) return nearest / Math.exp(map(Math.log(nearest / value), GIVE.distance));
  return value;
}

function moved(value: number, [low, high]: Range, map: Beyond): number {
  if (value > high) return high + map(value - high, GIVE.angle);
  if (value < low) return low - map(low - value, GIVE.angle);
  return value;
}

function within(value: number, [low, high]: Range): boolean {
  return low <= value && value <= high;
}
