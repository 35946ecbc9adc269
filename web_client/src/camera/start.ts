/** The camera that a scene is first seen from. */

import type { Manifest } from "../codec/types";
import { type Intrinsics, type Pose, poseOf } from "./pinhole";

export interface StartCamera {
  readonly name: string;
  readonly pose: Pose;
  readonly camera: Intrinsics;
}

/**
 * The capture camera of that name, or the first one if `name` is null.
 *
 * @throws Error that names the cameras there are if none has that name.
 */
export function startCamera(manifest: Manifest, name: string | null): StartCamera {
  const { cameras } = manifest;
  const found = name === null ? cameras[0] : cameras.find((camera) => camera.name === name);
  if (!found) {
    const names = cameras.map((camera) => camera.name).join(", ");
    throw new Error(`camera ${name}: the scene has no such camera; there are ${names}`);
  }
  return { name: found.name, pose: poseOf(found.worldToCamera), camera: found };
}
