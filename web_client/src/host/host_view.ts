/** Cameras of hosts: their views of a scene somewhere in their world, and capture cameras as their poses. */

import { startCamera } from "../camera/pinhole";
import { projectedIntrinsics, type Viewport } from "../camera/projection";
import { cross, dot, length, type Mat3, type Vec3 } from "../camera/vector";
import type { Manifest } from "../codec/types";
import type { View } from "../scene/view";
import type { HostSurface } from "./host_surface";

/** A host's camera, in the convention of OpenGL. Matrices are 4 by 4, by columns. */
export interface HostLens {
  /** The name in messages. */
  readonly name: string;
  /** From camera space to clip space. */
  readonly projection: ArrayLike<number>;
  /** From the scene's own space to camera space. */
  readonly modelView: ArrayLike<number>;
  /** The host's near distance; not that of the projection, which may be reversed, infinite or oblique. */
  readonly near: number;
}

export type HostDepth = Pick<HostSurface, "z" | "w">;

export interface HostView {
  readonly view: View;
  readonly depth: HostDepth;
}

/** Largest relative deviation of the three axes from equal lengths and right angles. */
const TOLERANCE = 1e-3;

/** Smallest near distance, as a lower bound of the host's: a lens almost at a splat would fill the picture. */
const NEAREST = 1e-6;

/**
 * The view of a scene by a host's camera, and its splats' depth for the host.
 *
 * @throws Error with one line for people if the camera has no perspective, or the scene is more than moved, turned and
 *   scaled.
 */
export function hostView({ name, projection: p, modelView: m, near }: HostLens, viewport: Viewport): HostView {
  if (p[15] !== 0 || p[3] !== 0 || p[7] !== 0 || p[1] !== 0 || p[4] !== 0) {
    throw new Error(`the camera ${name} has no perspective: splats need one that has`);
  }
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
      camera: projectedIntrinsics(p, viewport, Math.max(NEAREST, near) / scale),
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

/** The place of a camera in the scene's own space, for a host. */
export interface CapturePlace {
  /** From camera space, in the convention of OpenGL, to the scene's own space: 4 by 4, by columns. */
  readonly matrix: readonly number[];
  /** The vertical field of view of a picture of any shape that contains the capture's whole picture, degrees. */
  readonly fov: number;
}

/**
 * The place of a capture camera.
 *
 * @param name of the capture camera; the first if null.
 * @param aspect width of the host's picture by its height
 * @throws Error if the manifest has not arrived, or has no camera of that name.
 */
export function capturePlace(manifest: Manifest | null, name: string | null, aspect: number): CapturePlace {
  if (!manifest) throw new Error("the scene is not known yet: wait for the event manifest");
  const { pose, camera } = startCamera(manifest, name);
  const [r, t] = [pose.rotation, pose.translation];
  const at = [0, 1, 2].map((i) => -(r[i] * t[0] + r[i + 3] * t[1] + r[i + 6] * t[2]));
  const tangent = Math.max(camera.height / camera.fy, camera.width / camera.fx / aspect) / 2;
  return {
    // Columns are rows of the rotation; y and z inverted.
    matrix: [
      ...[r[0], r[1], r[2], 0],
      ...[-r[3], -r[4], -r[5], 0],
      ...[-r[6], -r[7], -r[8], 0],
      ...[at[0], at[1], at[2], 1],
    ],
    fov: (2 * Math.atan(tangent) * 180) / Math.PI,
  };
}
