/**
 * Limits of an orbit camera: it moves freely where the pictures of a scene were taken, pulls against a rubber band beyond
 * that, and springs back when let go (docs/format.md, "Captured space").
 *
 * Every function takes null for a space that is not known, which is without limits.
 */

import type { CapturedSpace } from "../codec/types";
import { azimuths, distances, elevations, type Range, type SeenLimits } from "./seen_limits";
import { add, cross, dot, length, rotateAbout, scale, subtract, type Vec3 } from "./vector";

/** Where an eye is around the point that it looks at. */
export interface OrbitPose {
  /** Radians from the front, counter-clockwise seen from above. Beyond pi and below -pi while a drag goes on and on. */
  readonly azimuth: number;
  /** Radians above the horizon. */
  readonly elevation: number;
  /** World units, above 0. */
  readonly distance: number;
}

/** A captured space, with narrower limits where what was seen is known. */
export type Space = CapturedSpace & { readonly limits?: SeenLimits | null };

/** What the angles of an orbit pose are counted from. */
export interface OrbitFrame {
  /** What the camera turns about. */
  readonly center: Vec3;
  /** Unit vector. */
  readonly up: Vec3;
  /** Unit vector at right angles to `up`. */
  readonly front: Vec3;
}

/** How far a rubber band gives way at most: radians, and the logarithm of a factor of the distance. */
const GIVE = { angle: 0.2, distance: Math.log(1.5) };
/** How fast a camera springs back: what is left of the way falls to 1 / e in this time, seconds. */
const SPRING = 0.12;
/** Share of the give from which on a camera that springs back has arrived. */
const ARRIVED = 1e-3;

/** The pose of an eye; straight above or below the centre the azimuth is 0. */
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

/** Where the eye of a pose is. */
export function eyeAt(pose: OrbitPose, { center, up, front }: OrbitFrame): Vec3 {
  const ahead = rotateAbout(front, up, pose.azimuth);
  const direction = add(scale(ahead, Math.cos(pose.elevation)), scale(up, Math.sin(pose.elevation)));
  return add(center, scale(direction, pose.distance));
}

/** Whether the scene can be looked at with trust from there. */
export function isInside({ azimuth, elevation, distance }: OrbitPose, space: Space | null): boolean {
  return (
    !space ||
    (within(azimuth, azimuths(space)) &&
      within(elevation, elevations(space, azimuth)) &&
      within(distance, distances(space, azimuth, elevation)))
  );
}

/**
 * The pose to show for one that a drag asks for: the same inside, and beyond the border ever less beyond, never farther
 * than the rubber band gives.
 *
 * Keep the asked pose while a drag lasts and show this one: limiting what is shown already would pull twice. A drag that
 * begins while the camera springs back begins at `unlimited` of what is shown, so that the picture does not jump.
 */
export function limited(asked: OrbitPose, space: Space | null): OrbitPose {
  return space ? mapped(asked, space, stretched) : asked;
}

/** The pose that `limited` shows as `shown`: its inverse, up to what the rubber band gives. */
export function unlimited(shown: OrbitPose, space: Space | null): OrbitPose {
  return space ? mapped(shown, space, unstretched) : shown;
}

/**
 * The pose inside that is nearest to `pose` in its azimuth, then in its elevation, then in its distance: where a camera that
 * is let go comes to rest.
 */
export function nearestInside(pose: OrbitPose, space: Space | null): OrbitPose {
  return space ? mapped(pose, space, () => 0) : pose;
}

/** Where a camera that was let go at `shown` is `seconds` later: on its way to `nearestInside`, exactly there in the end. */
export function springBack(shown: OrbitPose, space: Space | null, seconds: number): OrbitPose {
  const left = Math.exp(-seconds / SPRING);
  return space ? mapped(shown, space, (beyond, give) => (beyond > ARRIVED * give ? beyond * left : 0)) : shown;
}

/** Maps by how far a number is beyond its border, at least 0, given how far it may be. */
type Beyond = (beyond: number, give: number) => number;

/** Slope 1 at the border, so that the band is not felt as a step; `give` far away. */
const stretched: Beyond = (beyond, give) => (beyond * give) / (beyond + give);

/** A number at the band's very end, or past it, is taken for one near the end: nothing maps to it. */
const unstretched: Beyond = (beyond, give) => {
  const share = Math.min(beyond / give, 1 - ARRIVED);
  return (share / (1 - share)) * give;
};

/** Where a pose is beyond, its limits are those of the border beside it: the same for what `limited` makes of it. */
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
