/** The camera of a player, as pages move it. Without a scene nothing moves. */

import type { CameraMotion } from "../camera/gestures";
import type { Viewing, Viewpoint } from "./viewpoint";

export class PlayerCamera implements CameraMotion {
  readonly #viewpoint: () => Viewpoint | null;

  /** @param viewpoint of the scene that is there now; null without one. */
  constructor(viewpoint: () => Viewpoint | null) {
    this.#viewpoint = viewpoint;
  }

  /** Names of the scene's capture cameras; none until the scene is known. */
  get names(): readonly string[] {
    return this.#viewpoint()?.cameraNames ?? [];
  }

  /** The capture camera that the view began with; null until the scene is known. */
  get name(): string | null {
    return this.#viewpoint()?.cameraName ?? null;
  }

  /**
   * Look from a capture camera; from the first if null.
   *
   * @throws Error that names the cameras there are if none has that name.
   */
  look(name: string | null): void {
    this.#viewpoint()?.look(name);
  }

  /** Where the camera stands; null until the scene is known. */
  get view(): Viewing | null {
    return this.#viewpoint()?.viewing ?? null;
  }

  /** @throws RangeError if position, target and up do not say which way to look. */
  set view(view: Viewing) {
    this.#viewpoint()?.place(view);
  }

  /** Turn about what the camera looks at: to its left and upwards, radians. */
  turn(yaw: number, pitch: number): void {
    this.#viewpoint()?.turn(yaw, pitch);
  }

  /** Multiply the distance from what the camera looks at. */
  zoom(factor: number): void {
    this.#viewpoint()?.zoom(factor);
  }

  /** Move so that what the camera looks at goes along, CSS pixels. */
  pan(dx: number, dy: number): void {
    this.#viewpoint()?.pan(dx, dy);
  }

  /** Look around from where the camera stands: to its left and upwards, radians. */
  lookAround(yaw: number, pitch: number): void {
    this.#viewpoint()?.lookAround(yaw, pitch);
  }

  /** Go to the right, upwards and ahead, as shares of the distance that the camera began with from what it looks at. */
  travel(right: number, up: number, ahead: number): void {
    this.#viewpoint()?.travel(right, up, ahead);
  }

  /** Where the camera has been moved out of the captured space, let it spring back. */
  release(): void {
    this.#viewpoint()?.release();
  }

  /** Look at what is seen at a place of the picture, CSS pixels from its top left corner, and turn about that from now on. */
  focus(x: number, y: number): void {
    this.#viewpoint()?.focus(x, y);
  }

  /** Back to the capture camera that the view began with. */
  reset(): void {
    this.#viewpoint()?.reset();
  }
}
