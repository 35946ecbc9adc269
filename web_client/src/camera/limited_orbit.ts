/** An orbit camera with the soft limits of `captured_space.ts`. */

import type { CapturedSpace } from "../codec/types";
import {
  limited,
  nearestInside,
  type OrbitFrame,
  type OrbitPose,
  orbitPoseOf,
  type Space,
  springBack,
  unlimited,
} from "./captured_space";
import type { OrbitCamera } from "./orbit";
import { readSeenLimits, type SeenLimits } from "./seen_limits";
import { add, cross, dot, normalise, rotateAbout, row, scale, subtract, type Vec3 } from "./vector";

const ROUND = 2 * Math.PI;
const NUMBERS = ["azimuth", "elevation", "distance"] as const;

export class LimitedOrbit {
  readonly #frame: OrbitFrame;
  readonly space: Space | null;
  #azimuth = 0; // last displayed azimuth; decides the side of a camera that was pulled past the back

  /**
   * Limit an orbit camera.
   *
   * @param space around `center`; null for no limits.
   */
  constructor(
    readonly camera: OrbitCamera,
    center: Vec3,
    space: CapturedSpace | null,
  ) {
    this.space = space && { ...space, limits: seenLimits(space) };
    this.#frame = { center, up: camera.up, front: space?.front ?? [0, 0, 0] };
    this.#azimuth = this.#pose().azimuth;
  }

  /** Move the camera; beyond the border it follows ever less. */
  move(change: (camera: OrbitCamera) => void): void {
    const from = this.#pose();
    change(this.camera);
    if (!this.space) return;
    const to = this.#pose();
    const asked = unlimited(from, this.space);
    this.#show(
      to,
      limited(
        {
          azimuth: asked.azimuth + to.azimuth - from.azimuth,
          elevation: asked.elevation + to.elevation - from.elevation,
          distance: asked.distance * (to.distance / from.distance),
        },
        this.space,
      ),
    );
  }

  /** Whether the camera is beyond the border; it does not rest there. */
  get beyond(): boolean {
    const pose = this.#pose();
    const rest = nearestInside(pose, this.space);
    return NUMBERS.some((name) => Math.abs(pose[name] - rest[name]) > 1e-9 * Math.max(1, rest.distance));
  }

  /** Spring back for a number of seconds. */
  springBack(seconds: number): void {
    const pose = this.#pose();
    this.#show(pose, springBack(pose, this.space, seconds));
  }

  #pose(): OrbitPose {
    const pose = orbitPoseOf(this.camera.eye, this.#frame);
    return {
      azimuth: pose.azimuth + ROUND * Math.round((this.#azimuth - pose.azimuth) / ROUND),
      elevation: pose.elevation,
      distance: Math.max(pose.distance, 1e-9), // 0 in the centre itself
    };
  }

  /** Move the camera from one pose to another; inside, nothing is rounded. */
  #show(from: OrbitPose, to: OrbitPose): void {
    const [yaw, pitch] = [to.azimuth - from.azimuth, to.elevation - from.elevation];
    const factor = to.distance / from.distance;
    this.#azimuth = to.azimuth;
    const still = Math.abs(yaw) + Math.abs(pitch) + Math.abs(factor - 1) < 1e-12;
    if (!still) carry(this.camera, this.#frame.center, yaw, pitch, factor);
  }
}

/**
 * Move a camera with its whole view around `center`: by `yaw` about the scene's up vector, by `pitch` towards it, both in
 * radians; then to `factor` times its distance, without a turn.
 */
export function carry(camera: OrbitCamera, center: Vec3, yaw: number, pitch: number, factor: number): void {
  const { eye, up, pose } = camera;
  const level = normalise(cross(subtract(eye, center), up), row(pose.rotation, 0));
  const carried = (v: Vec3): Vec3 => rotateAbout(rotateAbout(v, level, pitch), up, yaw);
  const offset = carried(subtract(eye, center));
  const ahead = carried(row(pose.rotation, 2));
  const distance = Math.max(camera.closest, camera.distance - dot(scale(offset, factor - 1), ahead));
  const place = add(center, scale(offset, factor));
  camera.place(place, add(place, scale(ahead, distance)), carried(camera.upwards));
}

/** The document's seen limits; null, with a warning in the console, if they are invalid. */
function seenLimits(space: CapturedSpace): SeenLimits | null {
  try {
    return readSeenLimits(space);
  } catch (error) {
    // biome-ignore lint/suspicious/noConsole: a fault of the document, without consequences for a visitor
    console.warn(error);
    return null;
  }
}
