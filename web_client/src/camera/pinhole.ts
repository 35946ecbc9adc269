/**
 * Pinhole cameras in the OpenCV convention (x right, y down, z forward; pixel centres at +0.5), and their only
 * conversion to WebGL's clip space (y up).
 */

import type { Manifest, StartView } from "../codec/types";
import { add, apply, type Mat3, row, scale, type Vec3 } from "./vector";

/** A camera's pose: `rotation` p + `translation` is in camera space; the rotation is world-to-camera, row-major. */
export interface Pose {
  readonly rotation: Mat3;
  readonly translation: Vec3;
}

/** Intrinsics in pixels, except `near`; (cx, cy) is the principal point, from the top left corner. */
export interface Intrinsics {
  readonly width: number;
  readonly height: number;
  readonly fx: number;
  readonly fy: number;
  readonly cx: number;
  readonly cy: number;
  /** World units; splats with a nearer centre are not drawn. */
  readonly near: number;
}

/** The pose of a capture camera, from the rows of its 4x4 world-to-camera matrix. */
export function poseOf(worldToCamera: readonly (readonly number[])[]): Pose {
  const [a, b, c] = worldToCamera as [number[], number[], number[]];
  return {
    rotation: [a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]],
    translation: [a[3], b[3], c[3]],
  };
}

/** The camera's centre in the world: -R^T t. */
export function eyeOf(pose: Pose): Vec3 {
  const { rotation: r, translation: t } = pose;
  return scale(add(add(scale(row(r, 0), t[0]), scale(row(r, 1), t[1])), scale(row(r, 2), t[2])), -1);
}

/** The pose of a camera at `eye` with a world-to-camera rotation. */
export function poseAt(eye: Vec3, rotation: Mat3): Pose {
  return { rotation, translation: scale(apply(rotation, eye), -1) };
}

/** The same camera on a picture of another size; the axes scale apart, as `Camera.scaled` does on the server. */
export function resized(camera: Intrinsics, width: number, height: number): Intrinsics {
  const sx = width / camera.width;
  const sy = height / camera.height;
  return {
    width,
    height,
    fx: camera.fx * sx,
    fy: camera.fy * sy,
    cx: camera.cx * sx,
    cy: camera.cy * sy,
    near: camera.near,
  };
}

/** Largest enlargement beyond a wholly visible picture, on a screen no higher than wide: a little is cut off. */
const LARGEST_CROP = 1.2;

/**
 * The camera on a canvas of any shape. Around the capture's picture a scene has little but artefacts, so the picture
 * covers an upright canvas: its sides are cut off. Other canvases are covered up to `LARGEST_CROP`, because heads and
 * feet must stay. A `box` of the picture's plane stays in view, in the middle as far as the picture reaches.
 */
export function fitted(camera: Intrinsics, width: number, height: number, box?: StartView["box"] | null): Intrinsics {
  const [across, down] = [width / camera.width, height / camera.height];
  const covering = Math.max(across, down);
  const [left, top, right, bottom] = box ?? [camera.width / 2, camera.height / 2, camera.width / 2, camera.height / 2];
  const s = Math.min(
    covering,
    height > width ? covering : LARGEST_CROP * Math.min(across, down),
    width / (right - left),
    height / (bottom - top),
  );
  /** The principal point on the canvas. */
  const shifted = (middle: number, low: number, high: number, picture: number, canvas: number) => {
    const size = canvas / s;
    const within = between((low + high - size) / 2, Math.min(0, picture - size), Math.max(0, picture - size));
    return (middle - between(within, high - size, low)) * s;
  };
  return {
    width,
    height,
    fx: camera.fx * s,
    fy: camera.fy * s,
    cx: shifted(camera.cx, left, right, camera.width, width),
    cy: shifted(camera.cy, top, bottom, camera.height, height),
    near: camera.near,
  };
}

const between = (x: number, low: number, high: number): number => Math.min(Math.max(x, low), high);

/** Clip-space x, y in [-1, 1] of a pixel position. */
export function pixelToClip(x: number, y: number, size: { width: number; height: number }): [number, number] {
  return [(2 * x) / size.width - 1, 1 - (2 * y) / size.height];
}

/** Project a world point; returns [pixel x, pixel y, depth]. */
export function project(point: Vec3, pose: Pose, camera: Intrinsics): Vec3 {
  const [x, y, z] = add(apply(pose.rotation, point), pose.translation);
  return [(camera.fx * x) / z + camera.cx, (camera.fy * y) / z + camera.cy, z];
}

export interface StartCamera {
  readonly name: string;
  readonly pose: Pose;
  readonly camera: Intrinsics;
}

/**
 * The capture camera of that name, or, if `name` is null, the one to begin with.
 *
 * @throws Error that names the cameras there are if none has that name.
 */
export function startCamera(manifest: Manifest, name: string | null, tall = false): StartCamera {
  const { cameras, startViews } = manifest;
  const wanted = name ?? startViews[+tall]?.camera ?? cameras[0]?.name;
  const found = cameras.find((camera) => camera.name === wanted);
  if (!found) {
    const names = cameras.map((camera) => camera.name).join(", ");
    throw new Error(`camera ${name}: the scene has no such camera; there are ${names}`);
  }
  return { name: found.name, pose: poseOf(found.worldToCamera), camera: found };
}

/** The part of a start's picture to keep in view; null for a camera without one. */
export function startBox({ startViews }: Manifest, name: string, tall: boolean): StartView["box"] | null {
  const start = startViews[+tall];
  return start?.camera === name ? start.box : null;
}
