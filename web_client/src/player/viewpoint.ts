/** The viewpoint of a picture: a capture camera itself, or an orbit that began there; and the canvas's size. */

import type { CameraMotion } from "../camera/gestures";
import type { LimitedOrbit } from "../camera/limited_orbit";
import { MotionLoop } from "../camera/motion_loop";
import { OrbitCamera } from "../camera/orbit";
import { fitted, type Intrinsics, resized, type StartCamera, startBox, startCamera } from "../camera/pinhole";
import type { Vec3 } from "../camera/vector";
import type { Manifest } from "../codec/types";
import type { View } from "../scene/view";
import { observeBackingSize } from "./backing_size";
import type { SceneCanvas } from "./scene_canvas";

export interface ViewpointOptions {
  /** Name of the first capture camera; null for the first in the list. */
  readonly camera: string | null;
  /** True for exactly the capture camera, without motion. */
  readonly exact: boolean;
  /** Size of the picture in CSS pixels and in its backing store; null to fill the canvas sharply. */
  readonly size: { readonly width: number; readonly height: number } | null;
}

/** Share of the distance to the target below which splats fade: a way around one person may lead through another. */
const CLEAR = 0.15;
/**
 * Multiple of the near plane below which splats fade. Training places near planes at 0.6 of the smallest depth in a
 * camera's picture, so nothing fades in that picture.
 */
const CLEAR_NEARS = 1.5;

/** The owner of a viewpoint. */
export interface ViewpointEvents {
  /** Called after every change of the view. */
  changed(): void;
  /** The canvas with the viewpoint's pictures. */
  scene(): Pick<SceneCanvas, "renderer" | "shot">;
}

/** The position and direction of a camera, in the scene's world. */
export interface Viewing {
  readonly position: Vec3;
  /** The point in the middle of the picture, the centre of turns. */
  readonly target: Vec3;
  /** The upward direction of the picture; of any length. */
  readonly up: Vec3;
}

export class Viewpoint implements CameraMotion {
  #start: StartCamera | null = null;
  #orbit: OrbitCamera | null = null;
  #limited: Promise<LimitedOrbit | null> | null = null; // the orbit within the captured space; from the first motion on
  #moved: LimitedOrbit | null = null; // null until it has loaded
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

  /**
   * Start with a scene.
   *
   * @throws Error if the scene has no camera of the requested name.
   */
  begin(manifest: Manifest): void {
    this.#manifest = manifest;
    this.look(this.options.camera);
  }

  /** Name of the capture camera of the first view. */
  get cameraName(): string | null {
    return this.#start?.name ?? null;
  }

  get cameraNames(): readonly string[] {
    return this.#manifest?.cameras.map((camera) => camera.name) ?? [];
  }

  /** Look from a capture camera. */
  look(name: string | null): void {
    if (!this.#manifest) return;
    this.#start = startCamera(this.#manifest, name, this.#height > this.#width);
    const { center, up } = this.#manifest;
    this.#motion.stop();
    this.#orbit = new OrbitCamera(this.#start.pose, center, up);
    this.#limited = this.#moved = null;
    this.events.changed();
  }

  view(): View | null {
    if (!this.#start || !this.#orbit) return null;
    const camera = this.#intrinsics(this.#start);
    if (this.options.exact) return { pose: this.#start.pose, camera, still: 1 };
    // The near plane moves along: otherwise zooming in would cut a hole into the target.
    const { pose, closeness, distance } = this.#orbit;
    const near = camera.near * closeness;
    return { pose, camera: { ...camera, near }, clear: Math.max(CLEAR * distance, CLEAR_NEARS * near) };
  }

  /** The viewing; null until the manifest has arrived. */
  get viewing(): Viewing | null {
    const orbit = this.#orbit;
    return orbit && { position: orbit.eye, target: orbit.target, up: orbit.upwards };
  }

  /** Move the camera, also outside the captured space, with a new target to turn about. */
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
    const focal = this.#intrinsics(this.#start).fx / this.#pixelsPerCssPixel;
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

  async focus(x: number, y: number): Promise<void> {
    const [column, row] = [x * this.#pixelsPerCssPixel, y * this.#pixelsPerCssPixel];
    const part = await import("./glance").catch(() => null);
    const step = this.#orbit && part?.glance(this.#orbit, this.events.scene(), column, row);
    if (step) this.#run((seconds) => step(calm() ? Number.POSITIVE_INFINITY : seconds));
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
   * Use the orbit and its limits: at once if their module has loaded, else later, and without limits if it cannot be
   * loaded. Most visitors never move the camera.
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
      if (orbit !== this.#orbit) return; // the viewpoint has started again
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

  #intrinsics({ camera, name }: StartCamera): Intrinsics {
    const [width, height] = [this.#width, this.#height];
    if (!this.options.exact) return fitted(camera, width, height, startBox(this.#manifest!, name, height > width));
    return this.options.size ? resized(camera, width, height) : camera;
  }
}

/** Whether the visitor's system asks for less motion. */
function calm(): boolean {
  return matchMedia("(prefers-reduced-motion: reduce)").matches;
}
