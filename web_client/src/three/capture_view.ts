/** Puts a camera of three.js where a camera of the capture stood. */

import { Matrix4, type PerspectiveCamera, Vector3 } from "three";
import { startCamera } from "../camera/start";
import type { Manifest } from "../codec/types";

/**
 * @param world takes the scene's own space to the host's world.
 * @param name of the capture camera; the first if null.
 * @throws Error if the scene has no camera of that name.
 */
export function lookFrom(camera: PerspectiveCamera, world: Matrix4, manifest: Manifest, name: string | null): void {
  const { pose, camera: capture } = startCamera(manifest, name);
  const [r, t] = [pose.rotation, pose.translation];
  // World to camera; y and z the other way round, as three.js has them.
  const view = new Matrix4().set(
    ...[r[0], r[1], r[2], t[0]],
    ...[-r[3], -r[4], -r[5], -t[1]],
    ...[-r[6], -r[7], -r[8], -t[2]],
    ...[0, 0, 0, 1],
  );
  const placed = world.clone().multiply(view.invert());
  if (camera.parent) placed.premultiply(camera.parent.matrixWorld.clone().invert());
  placed.decompose(camera.position, camera.quaternion, new Vector3());
  // The whole of the capture's picture, on a picture of any shape.
  const tangent = Math.max(capture.height / capture.fy, capture.width / capture.fx / camera.aspect) / 2;
  camera.fov = (2 * Math.atan(tangent) * 180) / Math.PI;
  camera.updateProjectionMatrix();
  camera.updateMatrixWorld();
}
