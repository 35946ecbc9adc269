/** An orbit camera that stays where the pictures of its scene were taken: softly, see `captured_space.ts`. */

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
import type { Vec3 } from "./vector";

const ROUND = 2 * Math.PI;
const NUMBERS = ["azimuth", "elevation", "distance"] as const;

export class LimitedOrbit {
  readonly #frame: OrbitFrame;
  readonly space: Space | null;
  #azimuth = 0; // shown last; tells on which side a camera is that has been pulled past the back

  /** @param space where the camera stays, around `center`; null if it is free. */
  constructor(
    readonly camera: OrbitCamera,
    center: Vec3,
    space: CapturedSpace | null,
  ) {
    this.space = space && { ...space, limits: seenLimits(space) };
    this.#frame = { center, up: camera.up, front: space?.front ?? [0, 0, 0] };
    this.#azimuth = this.#pose().azimuth;
  }

  /** Move the camera; beyond the border of the space it follows ever less. */
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

  /** Whether the camera is beyond the border, where it does not rest. */
  get beyond(): boolean {
    const pose = this.#pose();
    const rest = nearestInside(pose, this.space);
    return NUMBERS.some((name) => Math.abs(pose[name] - rest[name]) > 1e-9 * Math.max(1, rest.distance));
  }

  /** Spring back for so many seconds. */
  springBack(seconds: number): void {
    const pose = this.#pose();
    this.#show(pose, springBack(pose, this.space, seconds));
  }

  #pose(): OrbitPose {
    const pose = orbitPoseOf(this.camera.eye, this.#frame);
    return {
      azimuth: pose.azimuth + ROUND * Math.round((this.#azimuth - pose.azimuth) / ROUND),
      elevation: pose.elevation,
      distance: Math.max(pose.distance, 1e-9), // in the centre itself
    };
  }

  /** Bring the camera from one pose to another; inside nothing is rounded. */
  #show(from: OrbitPose, to: OrbitPose): void {
    const [yaw, pitch] = [to.azimuth - from.azimuth, to.elevation - from.elevation];
    const factor = to.distance / from.distance;
    this.#azimuth = to.azimuth;
    const still = Math.abs(yaw) + Math.abs(pitch) + Math.abs(factor - 1) < 1e-12;
    if (!still) this.camera.carry(this.#frame.center, yaw, pitch, factor);
  }
}

/** Null, and said in the browser's console, where the document has them wrong: the camera stays in the space as it is. */
function seenLimits(space: CapturedSpace): SeenLimits | null {
  try {
    return readSeenLimits(space);
  } catch (error) {
    // biome-ignore lint/suspicious/noConsole: for whoever made the scene
    console.warn(error);
    return null;
  }
}
