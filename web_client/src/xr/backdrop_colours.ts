/**
 * The colours behind a scene in a headset: the mean of the scene above, about and below the horizon, dimmed. A black void
 * would look like a failure.
 */

import { add, dot, scale, type Vec3 } from "../camera/vector";
import { meanColour, type Panorama } from "./panorama";

/** sRGB, 0 to 1: straight above, at the horizon, straight below. */
export interface BackdropColours {
  readonly above: Vec3;
  readonly level: Vec3;
  readonly below: Vec3;
}

/** So much of the scene's colours, so that the scene stands out; most at the horizon, which tells where level is. */
const DIM = { above: 0.3, level: 0.45, below: 0.28 };
/** A part of the sphere of which less than this is covered takes its colour from the whole by so much. */
const COVERED = 0.1;

export const plain = (colour: Vec3): BackdropColours => ({ above: colour, level: colour, below: colour });

/** The colours for a scene that shows `panorama`; `up` is upwards in it. A scene that shows nothing has `background`. */
export function backdropColours(panorama: Panorama, up: Vec3, background: Vec3): BackdropColours {
  const whole = meanColour(panorama, () => 1);
  if (whole.covered === 0) return plain(background);
  const band = (dim: number, share: (height: number) => number): Vec3 => {
    const { colour, covered } = meanColour(panorama, (direction) => share(dot(direction, up)));
    const own = Math.min(1, covered / COVERED);
    const dimmed = scale(add(scale(colour, own), scale(whole.colour, 1 - own)), dim);
    return dimmed.map((value) => Math.min(1, Math.max(0, value))) as unknown as Vec3;
  };
  return {
    above: band(DIM.above, (height) => Math.max(0, height)),
    level: band(DIM.level, (height) => (1 - Math.abs(height)) ** 2),
    below: band(DIM.below, (height) => Math.max(0, -height)),
  };
}

export function mixed(from: BackdropColours, to: BackdropColours, share: number): BackdropColours {
  const mix = (a: Vec3, b: Vec3): Vec3 => add(scale(a, 1 - share), scale(b, share));
  return { above: mix(from.above, to.above), level: mix(from.level, to.level), below: mix(from.below, to.below) };
}
