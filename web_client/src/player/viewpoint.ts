/** From where a picture is seen: a capture camera as it is, or an orbit that began there; and the canvas's size. */

import type { CameraMotion } from "../camera/gestures";
import { OrbitCamera } from "../camera/orbit";
import { fitted, type Intrinsics, resized } from "../camera/pinhole";
import { type StartCamera, startCamera } from "../camera/start";
import type { Vec3 } from "../camera/vector";
import type { Manifest } from "../codec/types";
import { observeBackingSize } from "./backing_size";
import type { View } from "./view";

export interface ViewpointOptions {
  /** Name of the capture camera to begin with; the first if null. */
  readonly camera: string | null;
  /** True to look from exactly the capture camera, and never to move. */
  readonly exact: boolean;
  /** Size of the picture in CSS pixels and in its backing store; null to fill the canvas as sharply as it is worth. */
  readonly size: { readonly width: number; readonly height: number } | null;
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
  #manifest: Manifest | null = null;
  #width = 1; // backing pixels
  #height = 1;

  /** @param onChange called after every change of the view. */
  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly options: ViewpointOptions,
    readonly onChange: () => void,
    signal: AbortSignal,
  ) {
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
          onChange();
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
    this.#orbit = new OrbitCamera(this.#start.pose, this.#manifest.center, this.#manifest.up);
    this.onChange();
  }

  view(): View | null {
    if (!this.#start || !this.#orbit) return null;
    const camera = this.#intrinsics(this.#start.camera);
    if (this.options.exact) return { pose: this.#start.pose, camera };
    // The near plane comes along, else zooming in would cut a hole into what one looks at.
    return { pose: this.#orbit.pose, camera: { ...camera, near: camera.near * this.#orbit.closeness } };
  }

  /** Null until the scene is known. */
  get viewing(): Viewing | null {
    const orbit = this.#orbit;
    return orbit && { position: orbit.eye, target: orbit.target, up: orbit.upwards };
  }

  /** Stand somewhere else; the camera goes on turning about the new target. */
  place({ position, target, up }: Viewing): void {
    this.#orbit?.place(position, target, up);
    this.onChange();
  }

  turn(yaw: number, pitch: number): void {
    this.#orbit?.turn(yaw, pitch);
    this.onChange();
  }

  zoom(factor: number): void {
    this.#orbit?.zoom(factor);
    this.onChange();
  }

  pan(dx: number, dy: number): void {
    if (!this.#start) return;
    const { width } = this.canvas.getBoundingClientRect();
    const focal = this.#intrinsics(this.#start.camera).fx * (width / this.#width); // CSS pixels
    this.#orbit?.pan(dx, dy, focal);
    this.onChange();
  }

  reset(): void {
    this.look(this.cameraName);
  }

  #intrinsics(camera: Intrinsics): Intrinsics {
    const size = this.options.exact ? resized : fitted;
    if (this.options.exact && !this.options.size) return camera;
    return size(camera, this.#width, this.#height);
  }
}
