/** A turn of the view to the surface at a pixel; loaded at the first one. */

import type { OrbitCamera } from "../camera/orbit";
import { eyeOf, type Intrinsics, type Pose } from "../camera/pinhole";
import { add, cross, length, normalise, scale, subtract, type Vec3 } from "../camera/vector";
import { drawsHalfFloats, PictureTarget } from "../renderer/picture_target";
import type { Shot } from "../renderer/shot";
import type { SplatDrawer } from "../renderer/splat_drawer";
import type { SceneCanvas } from "./scene_canvas";

/** Duration, seconds. */
const DURATION = 0.3;
/** Sine of the angle to the up vector below which a view has no horizon. */
const STEEP = 0.02;
/** Least share of the splats in a pixel's colour for a depth. */
const SEEN = 0.2;

/**
 * The mean depth at a pixel, world units: of the splats there, each weighted by its share of the pixel's colour. Null
 * where the background is all but uncovered, and on a device that draws to no float format.
 */
function depthAt(splats: SplatDrawer, shot: Shot, x: number, y: number): number | null {
  const { gl } = splats;
  const { width, height } = shot.camera;
  if (!drawsHalfFloats(gl)) return null;
  const target = new PictureTarget(gl, width, height, "RGBA16F");
  const pixel = [x, height - 1 - y, 1, 1] as const;
  try {
    gl.enable(gl.SCISSOR_TEST); // one pixel costs next to nothing
    gl.scissor(...pixel);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    splats.draw(shot, [0, 0], "depth");
    const found = new Float32Array(4);
    gl.readPixels(...pixel, gl.RGBA, gl.FLOAT, found);
    const [sum, , , seen] = found;
    return seen >= SEEN ? sum / seen : null;
  } finally {
    gl.disable(gl.SCISSOR_TEST);
    target.dispose();
  }
}

/**
 * A step of a turn to the surface at a position of the picture, pixels of the backing store; null if nothing is there, or
 * the view would look straight up or down. It takes the seconds since the last one, and returns false after the end.
 */
export function glance(
  orbit: OrbitCamera,
  { renderer, shot }: Pick<SceneCanvas, "renderer" | "shot">,
  x: number,
  y: number,
): ((seconds: number) => boolean) | null {
  const depth = shot && depthAt(renderer.splats, shot, Math.floor(x), Math.floor(y));
  if (!shot || depth === null) return null;
  const from = { target: orbit.target, up: orbit.upwards };
  const point = unproject([x, y, depth], shot.pose, shot.camera);
  if (length(cross(normalise(subtract(point, orbit.eye)), orbit.up)) < STEEP) return null;
  let share = 0;
  return (seconds) => {
    share = Math.min(1, share + seconds / DURATION);
    const eased = share * share * (3 - 2 * share);
    orbit.place(orbit.eye, between(from.target, point, eased), between(from.up, orbit.up, eased));
    return share < 1;
  };
}

const between = (a: Vec3, b: Vec3, share: number): Vec3 => add(scale(a, 1 - share), scale(b, share));

/** The world point at a pixel position and a depth: the inverse of `project`. */
export function unproject([x, y, depth]: Vec3, pose: Pose, camera: Intrinsics): Vec3 {
  const ray: Vec3 = [(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1];
  return eyeOf({ rotation: pose.rotation, translation: subtract(pose.translation, scale(ray, depth)) });
}
