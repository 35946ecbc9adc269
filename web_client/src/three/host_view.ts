/** Cameras of three.js: their views of a scene somewhere in their world, and capture cameras as their poses. */

import { type Camera, Matrix4, type PerspectiveCamera, Vector3 } from "three";
import { startCamera } from "../camera/pinhole";
import { projectedIntrinsics, type Viewport } from "../camera/projection";
import { cross, dot, length, type Mat3, type Vec3 } from "../camera/vector";
import type { Manifest } from "../codec/types";
import type { View } from "../scene/view";
import type { HostSurface } from "./host_surface";

export interface HostView {
  readonly view: View;
  readonly depth: Pick<HostSurface, "z" | "w">;
}

/** Largest relative deviation of the three axes from equal lengths and right angles. */
const TOLERANCE = 1e-3;

/** Smallest near distance, as a lower bound of the host's: a lens almost at a splat would fill the picture. */
const NEAREST = 1e-6;

/**
 * The view of a scene with its own space taken to the host's world by `world`, and its splats' depth for the host.
 *
 * @throws Error with one line for people if the camera has no perspective, or `world` does more than move, turn and
 *   scale.
 */
export function hostView(camera: Camera, world: Matrix4, viewport: Viewport): HostView {
  const p = camera.projectionMatrix.elements;
  if (p[15] !== 0 || p[3] !== 0 || p[7] !== 0 || p[1] !== 0 || p[4] !== 0) {
    throw new Error(`the camera ${camera.name || camera.type} has no perspective: splats need a PerspectiveCamera`);
  }
  const m = camera.matrixWorldInverse.clone().multiply(world).elements;
  const scale = uniformScale(m);
  // Rows in OpenCV axes: y and z inverted. Lengths in the scene's own units.
  const rows = [0, 1, 2].map((i) => [m[i], m[i + 4], m[i + 8], m[i + 12]].map((v) => ((i ? -1 : 1) * v) / scale));
  const rotation = rows.flatMap((row) => row.slice(0, 3)) as unknown as Mat3;
  const row = (i: number): [number, number, number, number] => [
    p[i] * scale,
    -p[i + 4] * scale,
    -p[i + 8] * scale,
    p[i + 12],
  ];
  return {
    view: {
      pose: { rotation, translation: [rows[0][3], rows[1][3], rows[2][3]] },
      camera: projectedIntrinsics(p, viewport, nearOf(camera) / scale),
    },
    depth: { z: row(2), w: row(3) },
  };
}

/** The common scale of a matrix. */
function uniformScale(m: ArrayLike<number>): number {
  const axes = [0, 4, 8].map((i): Vec3 => [m[i], m[i + 1], m[i + 2]]);
  const [x, y, z] = axes;
  const lengths = axes.map(length);
  const longest = Math.max(...lengths);
  const askew = Math.max(Math.abs(dot(x, y)), Math.abs(dot(y, z)), Math.abs(dot(z, x)));
  const even = longest - Math.min(...lengths) <= TOLERANCE * longest && askew <= TOLERANCE * longest * longest;
  if (!even || !(dot(cross(x, y), z) > 0)) {
    const scales = lengths.map((size) => Number(size.toPrecision(4))).join(", ");
    throw new Error(
      `the scene is scaled by ${scales}: splats need one positive scale for all axes, the parents' included`,
    );
  }
  return (lengths[0] + lengths[1] + lengths[2]) / 3;
}

/** The host's near distance; not that of the projection matrix, which may be reversed, infinite or oblique. */
function nearOf(camera: Camera): number {
  const { near } = camera as Camera & { near?: number };
  return Math.max(NEAREST, near ?? NEAREST);
}

/**
 * Move a camera to a capture camera.
 *
 * @param world takes the scene's own space to the host's world.
 * @param name of the capture camera; the first if null.
 * @throws Error if the scene has no camera of that name.
 */
export function lookFrom(camera: PerspectiveCamera, world: Matrix4, manifest: Manifest, name: string | null): void {
  const { pose, camera: capture } = startCamera(manifest, name);
  const [r, t] = [pose.rotation, pose.translation];
  // World to camera; y and z inverted, as in three.js.
  const view = new Matrix4().set(
    ...[r[0], r[1], r[2], t[0]],
    ...[-r[3], -r[4], -r[5], -t[1]],
    ...[-r[6], -r[7], -r[8], -t[2]],
    ...[0, 0, 0, 1],
  );
  const placed = world.clone().multiply(view.invert());
  if (camera.parent) placed.premultiply(camera.parent.matrixWorld.clone().invert());
  placed.decompose(camera.position, camera.quaternion, new Vector3());
  // The whole of the capture's picture fits into a picture of any shape.
  const tangent = Math.max(capture.height / capture.fy, capture.width / capture.fx / camera.aspect) / 2;
  camera.fov = (2 * Math.atan(tangent) * 180) / Math.PI;
  camera.updateProjectionMatrix();
  camera.updateMatrixWorld();
}
