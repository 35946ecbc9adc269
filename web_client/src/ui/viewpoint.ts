/** From where the page's picture is seen: a capture camera as it is, or an orbit that began there; and the canvas's size. */

import type { CameraMotion } from "../camera/gestures";
import { OrbitCamera } from "../camera/orbit";
import { fitted, type Intrinsics, resized } from "../camera/pinhole";
import { type StartCamera, startCamera } from "../camera/start";
import type { Manifest } from "../codec/types";
import type { View } from "../player/view";
import { observeBackingSize } from "./backing_size";
import type { ViewParameters } from "./view_parameters";

export class Viewpoint implements CameraMotion {
  #start: StartCamera | null = null;
  #orbit: OrbitCamera | null = null;
  #manifest: Manifest | null = null;
  #width = 1; // backing pixels
  #height = 1;

  /** @param onChange called after every change of the view. */
  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly parameters: ViewParameters,
    readonly onChange: () => void,
    signal: AbortSignal,
  ) {
    const { size } = parameters;
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

  /** @throws Error if the scene has no camera of the address's name. */
  begin(manifest: Manifest): void {
    this.#manifest = manifest;
    this.look(this.parameters.camera);
  }

  /** Name of the capture camera that the view began with. */
  get cameraName(): string | null {
    return this.#start?.name ?? null;
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
    if (this.parameters.exact) return { pose: this.#start.pose, camera };
    // The near plane comes along, else zooming in would cut a hole into what one looks at.
    return { pose: this.#orbit.pose, camera: { ...camera, near: camera.near * this.#orbit.closeness } };
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
    const size = this.parameters.exact ? resized : fitted;
    if (this.parameters.exact && !this.parameters.size) return camera;
    return size(camera, this.#width, this.#height);
  }
}
