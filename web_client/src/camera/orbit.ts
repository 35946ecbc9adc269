/**
 * Orbit camera. It starts from any pose, turns about a target, and keeps the horizon: sideways drags turn about the
 * scene's up vector, upward drags about the camera's right axis.
 */

import { eyeOf, type Pose, poseAt } from "./pinhole";
import {
  add,
  cross,
  dot,
  fromRows,
  length,
  type Mat3,
  normalise,
  rotateAbout,
  row,
  scale,
  subtract,
  type Vec3,
} from "./vector";

const POLE_MARGIN = 0.02; // radians; a view along the up vector has no horizon
const CLOSEST = 0.02; // share of the first distance
const FARTHEST = 50;

export class OrbitCamera {
  #rotation: Mat3;
  #target: Vec3;
  #distance: number;
  #first: number;

  /**
   * `target` is the centre of the orbit; it is moved onto the view axis so that the first picture is exactly `pose`.
   */
  constructor(
    pose: Pose,
    target: Vec3,
    readonly up: Vec3,
  ) {
    const eye = eyeOf(pose);
    const forward = row(pose.rotation, 2);
    const along = dot(subtract(target, eye), forward);
    this.#rotation = pose.rotation;
    this.#distance = along > 1e-3 ? along : 1;
    this.#first = this.#distance;
    this.#target = add(eye, scale(forward, this.#distance));
  }

  get pose(): Pose {
    return poseAt(this.eye, this.#rotation);
  }

  get eye(): Vec3 {
    return subtract(this.#target, scale(row(this.#rotation, 2), this.#distance));
  }

  /** The point that the camera looks at and turns about. */
  get target(): Vec3 {
    return this.#target;
  }

  /** The unit vector that points upwards in the picture. */
  get upwards(): Vec3 {
    return scale(row(this.#rotation, 1), -1);
  }

  get distance(): number {
    return this.#distance;
  }

  /** The least distance to the target. */
  get closest(): number {
    return this.#first * CLOSEST;
  }

  /** The distance to the target relative to the first one, at most 1. */
  get closeness(): number {
    return Math.min(1, this.#distance / this.#first);
  }

  /** Turn the camera about the target: positive `yaw` moves it to its left, positive `pitch` upwards. Radians. */
  turn(yaw: number, pitch: number): void {
    const right = row(this.#rotation, 0);
    const forward = row(this.#rotation, 2);
    const elevation = Math.asin(Math.max(-1, Math.min(1, -dot(forward, this.up))));
    const limit = Math.PI / 2 - POLE_MARGIN;
    // Never past a pole; but a first pose beyond the limit may return.
    const allowed = Math.max(Math.min(elevation, -limit), Math.min(Math.max(elevation, limit), elevation + pitch));
    const tilt = (v: Vec3): Vec3 => rotateAbout(v, right, elevation - allowed);
    const swing = (v: Vec3): Vec3 => rotateAbout(v, this.up, -yaw);
    const z = normalise(swing(tilt(forward)));
    const down = swing(tilt(row(this.#rotation, 1)));
    const y = normalise(subtract(down, scale(z, dot(down, z))));
    const x: Vec3 = [y[1] * z[2] - y[2] * z[1], y[2] * z[0] - y[0] * z[2], y[0] * z[1] - y[1] * z[0]];
    this.#rotation = fromRows(x, y, z);
  }

  /**
   * Look from `eye` at `target`, with `up` upwards in the picture.
   *
   * @throws RangeError if the three define no direction.
   */
  place(eye: Vec3, target: Vec3, up: Vec3): void {
    const forward = subtract(target, eye);
    const distance = length(forward);
    const right = cross(forward, up);
    if (!(length(right) > 1e-9 * distance * length(up))) {
      throw new RangeError(`a camera at ${eye} that looks at ${target} with ${up} upwards has no direction`);
    }
    const z = normalise(forward);
    const x = normalise(right);
    this.#rotation = fromRows(x, cross(z, x), z);
    this.#target = target;
    this.#distance = distance;
  }

  /** Multiply the distance to the target. */
  zoom(factor: number): void {
    const distance = this.#distance * factor;
    this.#distance = Math.max(this.closest, Math.min(this.#first * FARTHEST, distance));
  }

  /** Turn the camera about itself: positive `yaw` to its left, positive `pitch` upwards. Radians. */
  lookAround(yaw: number, pitch: number): void {
    const { eye } = this;
    this.turn(-yaw, -pitch);
    this.#target = add(eye, scale(row(this.#rotation, 2), this.#distance));
  }

  /** Move along the camera's right axis, the scene's up vector and the view axis, by shares of the first distance. */
  travel(right: number, up: number, ahead: number): void {
    const aside = add(scale(row(this.#rotation, 0), right), scale(row(this.#rotation, 2), ahead));
    this.#target = add(this.#target, scale(add(aside, scale(this.up, up)), this.#first));
  }

  /** Move camera and target across the picture, so that the target follows a drag of (dx, dy) pixels. */
  pan(dx: number, dy: number, focal: number): void {
    const s = this.#distance / focal;
    const shift = add(scale(row(this.#rotation, 0), -dx * s), scale(row(this.#rotation, 1), -dy * s));
    this.#target = add(this.#target, shift);
  }
}
