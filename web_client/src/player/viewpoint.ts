/** From where a picture is seen: a capture camera as it is, or an orbit that began there; and the canvas's size. */

import type { CameraMotion } from "../camera/gestures";
import type { LimitedOrbit } from "../camera/limited_orbit";
import { MotionLoop } from "../camera/motion_loop";
import { OrbitCamera } from "../camera/orbit";
import { fitted, type Intrinsics, resized, unproject } from "../camera/pinhole";
import { type StartCamera, startCamera } from "../camera/start";
import { add, cross, length, normalise, scale, subtract, type Vec3 } from "../camera/vector";
import type { Manifest } from "../codec/types";
import type { View } from "../scene/view";
import { observeBackingSize } from "./backing_size";

export interface ViewpointOptions {
  /** Name of the capture camera to begin with; the first if null. */
  readonly camera: string | null;
  /** True to look from exactly the capture camera, and never to move. */
  readonly exact: boolean;
  /** Size of the picture in CSS pixels and in its backing store; null to fill the canvas as sharply as it is worth. */
  readonly size: { readonly width: number; readonly height: number } | null;
}

/** How long the camera takes to look at another point, seconds. */
const GLANCE = 0.3;
/**
 * What is nearer than this share of the distance to what the camera turns about fades towards the near plane: else a way
 * around one person leads through the back of another.
 */
const CLEAR = 0.15;
/**
 * And what is nearer than so many near planes. Training puts those at 0.6 of the way to the nearest that a camera sees, so
 * that nothing fades in that camera's own picture.
 */
const CLEAR_NEARS = 1.5;
/** Sine of the angle to the up vector from which on there is no horizon to look along. */
const STEEP = 0.02;

/** What a viewpoint needs of whoever draws. */
export interface ViewpointEvents {
  /** Called after every change of the view. */
  changed(): void;
  /** How far away, world units along the view axis, what is seen at a pixel of the backing store is; null if nothing is. */
  depthAt(x: number, y: number): number | null;
}

/** Where a camera stands, in the scene's world. */
export interface Viewing {
  readonly position: Vec3;
  /** The point in the middle of the picture, which the camera turns about. */
  readonly target: Vec3;
  /** Upwards in the picture; of any length. */
  readonly up: Vec3;
}

export class Viewpoint implements CameraMotion {
  #start: StartCamera | null = null;
  #orbit: OrbitCamera | null = null;
  #limited: Promise<LimitedOrbit | null> | null = null; // the same, within the captured space; from the first move on
  #moved: LimitedOrbit | null = null; // once it is there
  readonly #motion: MotionLoop;
  #manifest: Manifest | null = null;
  #width = 1; // backing pixels
  #height = 1;

  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly options: ViewpointOptions,
    readonly events: ViewpointEvents,
    signal: AbortSignal,
  ) {
    this.#motion = new MotionLoop(signal);
    const { size } = options;
    if (size) {
      canvas.style.width = `${size.width}px`;
      canvas.style.height = `${size.height}px`;
      canvas.style.inset = "0 auto auto 0";
      [this.#width, this.#height] = [size.width, size.height];
    } else {
      observeBackingSize(
        canvas,
        ({ width, height }) => {
          [this.#width, this.#height] = [width, height];
          events.changed();
        },
        signal,
      );
    }
  }

  /** @throws Error if the scene has no camera of the name that was asked for. */
  begin(manifest: Manifest): void {
    this.#manifest = manifest;
    this.look(this.options.camera);
  }

  /** Name of the capture camera that the view began with. */
  get cameraName(): string | null {
    return this.#start?.name ?? null;
  }

  get cameraNames(): readonly string[] {
    return this.#manifest?.cameras.map((camera) => camera.name) ?? [];
  }

  /** Go to a capture camera. */
  look(name: string | null): void {
    if (!this.#manifest) return;
    this.#start = startCamera(this.#manifest, name);
    const { center, up } = this.#manifest;
    this.#motion.stop();
    this.#orbit = new OrbitCamera(this.#start.pose, center, up);
    this.#limited = this.#moved = null;
    this.events.changed();
  }

  view(): View | null {
    if (!this.#start || !this.#orbit) return null;
    const camera = this.#intrinsics(this.#start.camera);
    if (this.options.exact) return { pose: this.#start.pose, camera };
    // The near plane comes along, else zooming in would cut a hole into what one looks at.
    const { pose, closeness, distance } = this.#orbit;
    const near = camera.near * closeness;
    return { pose, camera: { ...camera, near }, clear: Math.max(CLEAR * distance, CLEAR_NEARS * near) };
  }

  /** Null until the scene is known. */
  get viewing(): Viewing | null {
    const orbit = this.#orbit;
    return orbit && { position: orbit.eye, target: orbit.target, up: orbit.upwards };
  }

  /** Stand somewhere else, be it outside the captured space; the camera goes on turning about the new target. */
  place({ position, target, up }: Viewing): void {
    this.#motion.stop();
    this.#orbit?.place(position, target, up);
    this.events.changed();
  }

  turn(yaw: number, pitch: number): void {
    this.#move((orbit) => orbit.turn(yaw, pitch));
  }

  zoom(factor: number): void {
    this.#move((orbit) => orbit.zoom(factor));
  }

  pan(dx: number, dy: number): void {
    if (!this.#start) return;
    const focal = this.#intrinsics(this.#start.camera).fx / this.#pixelsPerCssPixel;
    this.#move((orbit) => orbit.pan(dx, dy, focal));
  }

  lookAround(yaw: number, pitch: number): void {
    this.#move((orbit) => orbit.lookAround(yaw, pitch));
  }

  travel(right: number, up: number, ahead: number): void {
    this.#move((orbit) => orbit.travel(right, up, ahead));
  }

  release(): void {
    this.#within((limited) => {
      if (!limited?.beyond || this.#motion.running) return;
      this.#run((seconds) => {
        limited.springBack(calm() ? Number.POSITIVE_INFINITY : seconds);
        return limited.beyond;
      });
    });
  }

  focus(x: number, y: number): void {
    const view = this.view();
    const orbit = this.#orbit;
    if (!view || !orbit) return;
    const [column, row] = [x * this.#pixelsPerCssPixel, y * this.#pixelsPerCssPixel];
    const depth = this.events.depthAt(Math.floor(column), Math.floor(row));
    if (depth === null) return;
    const from = { target: orbit.target, up: orbit.upwards };
    const point = unproject([column, row, depth], view.pose, view.camera);
    if (length(cross(normalise(subtract(point, orbit.eye)), orbit.up)) < STEEP) return;
    let share = 0;
    this.#run((seconds) => {
      share = calm() ? 1 : Math.min(1, share + seconds / GLANCE);
      const eased = share * share * (3 - 2 * share);
      orbit.place(orbit.eye, between(from.target, point, eased), between(from.up, orbit.up, eased));
      return share < 1;
    });
  }

  reset(): void {
    this.look(this.cameraName);
  }

  get #pixelsPerCssPixel(): number {
    return this.#width / this.canvas.getBoundingClientRect().width;
  }

  #move(change: (orbit: OrbitCamera) => void): void {
    this.#motion.stop();
    this.#within((limited, orbit) => {
      if (limited) limited.move(change);
      else change(orbit);
      this.events.changed();
    });
  }

  /**
   * Do something with the orbit and what keeps it within the captured space: at once if that is here, else when it has come,
   * and with the orbit alone if it cannot be had. Most visitors never move the camera.
   */
  #within(then: (limited: LimitedOrbit | null, orbit: OrbitCamera) => void): void {
    const orbit = this.#orbit;
    if (!orbit || !this.#manifest) return;
    if (this.#moved) {
      then(this.#moved, orbit);
      return;
    }
    const { center, capturedSpace } = this.#manifest;
    this.#limited ??= import("../camera/limited_orbit")
      .then(({ LimitedOrbit }) => new LimitedOrbit(orbit, center, capturedSpace))
      .catch(() => null);
    void this.#limited.then((limited) => {
      if (orbit !== this.#orbit) return; // it has begun anew
      this.#moved = limited;
      then(limited, orbit);
    });
  }

  #run(step: (seconds: number) => boolean): void {
    this.#motion.run((seconds) => {
      const more = step(seconds);
      this.events.changed();
      return more;
    });
  }

  #intrinsics(camera: Intrinsics): Intrinsics {
    const size = this.options.exact ? resized : fitted;
    if (this.options.exact && !this.options.size) return camera;
    return size(camera, this.#width, this.#height);
  }
}

const between = (a: Vec3, b: Vec3, share: number): Vec3 => add(scale(a, 1 - share), scale(b, share));

/** Whether the visitor's system asks for less motion. */
function calm(): boolean {
  return matchMedia("(prefers-reduced-motion: reduce)").matches;
}
