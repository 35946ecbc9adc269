/** The camera that a scene is first seen from. */

import type { Manifest } from "../codec/types";
import { type Intrinsics, type Pose, poseAt, poseOf } from "./pinhole";
import { cross, dot, fromRows, normalise, scale, subtract, type Vec3 } from "./vector";

export interface StartCamera {
  readonly name: string | null;
  readonly pose: Pose;
  readonly camera: Intrinsics;
}

/**
 * The capture camera of that name, the first one if `name` is null, or a made one if the scene has none.
 *
 * @throws Error that names the cameras there are if there is none of that name.
 */
export function startCamera(manifest: Manifest, name: string | null): StartCamera {
  const found = name === null ? manifest.cameras[0] : manifest.cameras.find((camera) => camera.name === name);
  if (found) return { name: found.name, pose: poseOf(found.worldToCamera), camera: found };
  if (name !== null) {
    const names = manifest.cameras.map((camera) => camera.name).join(", ") || "none";
    throw new Error(`camera ${name}: the scene has no such camera; there are ${names}`);
  }
  return { name: null, ...lookAtCentre(manifest) };
}

/** From the scene's usual distance, level, with a field of view of 53 degrees. */
function lookAtCentre(manifest: Manifest): { pose: Pose; camera: Intrinsics } {
  const down = scale(manifest.up, -1);
  const aside: Vec3 = Math.abs(down[0]) < 0.9 ? [1, 0, 0] : [0, 0, 1];
  const right = normalise(subtract(aside, scale(down, dot(down, aside))));
  const forward = cross(right, down);
  const eye = subtract(manifest.center, scale(forward, manifest.extent));
  const camera = { width: 1280, height: 720, fx: 1280, fy: 1280, cx: 640, cy: 360, near: 0.01 };
  return { pose: poseAt(eye, fromRows(right, down, forward)), camera };
}
