/** The fading of static splats away from the cameras of a sparse rig (docs/format.md, "Cones"). */

import { Field } from "../codec/manifest";
import type { Manifest } from "../codec/types";
import { eyeOf, type Pose } from "./pinhole";
import { dot, normalise, subtract, type Vec3 } from "./vector";

/** Angles from the nearest camera's direction up to which nothing fades, and from which on nothing is left, radians. */
const FADE = [10, 30].map((degrees) => (degrees * Math.PI) / 180);

/** Splats lie over one another: several of them cover about half where the opacity of each is a fourth. */
const STACKED = 2;

/** The factor of static splats' opacity in a view, from 0 to 1; 1 everywhere for a dense rig. */
export function stillShare({
  center,
  capturedSpace,
}: Pick<Manifest, "center" | "capturedSpace">): (view: { readonly pose: Pose }) => number {
  const cones = readCones(capturedSpace?.cones);
  if (cones.length === 0) return () => 1;
  return ({ pose }) => {
    const direction = normalise(subtract(eyeOf(pose), center), cones[0]);
    const angle = Math.acos(Math.min(1, Math.max(...cones.map((cone) => dot(cone, direction)))));
    const share = Math.min(1, Math.max(0, (FADE[1] - angle) / (FADE[1] - FADE[0])));
    return (share * share * (3 - 2 * share)) ** STACKED;
  };
}

/** None, with a warning in the console, if the document's are invalid. */
function readCones(cones: unknown): Vec3[] {
  try {
    return cones === undefined
      ? []
      : new Field("manifest.captured_space.cones", cones).items().map((one) => one.triple());
  } catch (error) {
    // biome-ignore lint/suspicious/noConsole: a fault of the document, without consequences for a visitor
    console.warn(error);
    return [];
  }
}
