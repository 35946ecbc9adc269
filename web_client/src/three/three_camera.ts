/** Cameras of three.js: their pictures of a scene, and capture cameras as their poses. */

import { type Camera, Matrix4, type PerspectiveCamera, Vector3 } from "three";
import type { Viewport } from "../camera/projection";
import type { HostPicture } from "../host/host_drawer";
import type { CapturePlace } from "../host/host_view";

/** The picture of a camera, of a scene with its own space taken to the host's world by `world`. */
export function threePicture(camera: Camera, world: Matrix4, viewport: Viewport): HostPicture {
  return {
    viewport,
    name: camera.name || camera.type,
    projection: camera.projectionMatrix.elements,
    modelView: camera.matrixWorldInverse.clone().multiply(world).elements,
    near: (camera as Camera & { near?: number }).near ?? 0,
  };
}

/** Move a camera to the place of a capture camera in such a scene. */
export function placeCamera(camera: PerspectiveCamera, world: Matrix4, { matrix, fov }: CapturePlace): void {
  const placed = new Matrix4().fromArray(matrix).premultiply(world);
  if (camera.parent) placed.premultiply(camera.parent.matrixWorld.clone().invert());
  placed.decompose(camera.position, camera.quaternion, new Vector3());
  camera.fov = fov;
  camera.updateProjectionMatrix();
  camera.updateMatrixWorld();
}
