/** The view of a box: places of the picture, CSS pixels, and points and rays of the world. */

import { fitted, type Intrinsics, type Pose, poseAt, project, startBox, startCamera } from "../camera/pinhole";
import { add, cross, dot, fromRows, normalise, row, scale, subtract, type Vec3 } from "../camera/vector";
import type { HgsPlayer } from "../player/hgs_player";
import type { Viewing } from "../player/viewpoint";

export interface CropView {
  readonly pose: Pose;
  readonly camera: Intrinsics;
  readonly eye: Vec3;
}

export type Pixel = readonly [number, number];

/** The view of the player's picture at its size on the page, or of another viewing; null until there is one. */
export function cropViewOf(
  player: HgsPlayer,
  { width, height }: { width: number; height: number },
  viewing: Viewing | null = player.camera.view,
): CropView | null {
  const { manifest, camera } = player;
  if (!manifest || !viewing || !(width > 0 && height > 0)) return null;
  const ahead = normalise(subtract(viewing.target, viewing.position));
  const right = normalise(cross(ahead, viewing.up));
  const pose = poseAt(viewing.position, fromRows(right, cross(ahead, right), ahead));
  const start = startCamera(manifest, camera.name);
  const box = startBox(manifest, start.name, height > width);
  return { pose, camera: fitted(start.camera, width, height, box), eye: viewing.position };
}

/** The place of a point; null if it is behind the eye. */
export function seenAt(point: Vec3, { pose, camera }: CropView): Pixel | null {
  const [x, y, depth] = project(point, pose, camera);
  return depth > camera.near * 0.01 ? [x, y] : null;
}

/** The places of a line's ends, with the part behind the eye cut off; null if all of it is. */
export function seenLine(from: Vec3, to: Vec3, view: CropView): readonly [Pixel, Pixel] | null {
  const depth = (point: Vec3) => project(point, view.pose, view.camera)[2];
  const nearest = view.camera.near * 0.1;
  const [a, b] = [depth(from), depth(to)];
  if (a < nearest && b < nearest) return null;
  const cut = add(from, scale(subtract(to, from), (nearest - a) / (b - a)));
  const start = seenAt(a < nearest ? cut : from, view);
  const end = seenAt(b < nearest ? cut : to, view);
  return start && end && [start, end];
}

/** The unit direction of the ray through a place. */
export function rayThrough([x, y]: Pixel, { pose, camera }: CropView): Vec3 {
  const [right, down, ahead] = ([0, 1, 2] as const).map((i) => row(pose.rotation, i)) as [Vec3, Vec3, Vec3];
  const aside = add(scale(right, (x - camera.cx) / camera.fx), scale(down, (y - camera.cy) / camera.fy));
  return normalise(add(aside, ahead));
}

/** Position along a line, in lengths of its unit direction, nearest to the ray through a place. */
export function alongLine(origin: Vec3, direction: Vec3, pixel: Pixel, view: CropView): number | null {
  const ray = rayThrough(pixel, view);
  const slant = dot(ray, direction);
  const apart = 1 - slant * slant;
  if (apart < 1e-4) return null; // the line points at the eye
  const between = subtract(view.eye, origin);
  return (dot(between, direction) - slant * dot(between, ray)) / apart;
}

/**
 * The intersection of a plane through a point with the ray through a place; null if the plane is seen from its edge, or
 * behind the eye.
 */
export function onPlane(point: Vec3, normal: Vec3, pixel: Pixel, view: CropView): Vec3 | null {
  const ray = rayThrough(pixel, view);
  const slant = dot(ray, normal);
  if (Math.abs(slant) < 0.02) return null;
  const distance = dot(subtract(point, view.eye), normal) / slant;
  return distance > 0 ? add(view.eye, scale(ray, distance)) : null;
}
