/** The camera of a player, for pages. Without a scene nothing moves. */

import type { CameraMotion } from "../camera/gestures";
import type { Viewing, Viewpoint } from "./viewpoint";

export class PlayerCamera implements CameraMotion {
  readonly #viewpoint: () => Viewpoint | null;

  /**
   * Control a viewpoint.
   *
   * @param viewpoint of the present scene; null without one.
   */
  constructor(viewpoint: () => Viewpoint | null) {
    this.#viewpoint = viewpoint;
  }

  /** Names of the scene's capture cameras; none until the manifest has arrived. */
  get names(): readonly string[] {
    return this.#viewpoint()?.cameraNames ?? [];
  }

  /** The capture camera of the first view; null until the manifest has arrived. */
  get name(): string | null {
    return this.#viewpoint()?.cameraName ?? null;
  }

  /**
   * Look from a capture camera; null is the first.
   *
   * @throws Error that names the existing cameras if none has that name.
   */
  look(name: string | null): void {
    this.#viewpoint()?.look(name);
  }

  /** The camera's position; null until the manifest has arrived. */
  get view(): Viewing | null {
    return this.#viewpoint()?.viewing ?? null;
  }

  /**
   * Move the camera.
   *
   * @throws RangeError if position, target and up define no direction.
   */
  set view(view: Viewing) {
    this.#viewpoint()?.place(view);
  }

  /** Turn about the target: to the camera's left and upwards, radians. */
  turn(yaw: number, pitch: number): void {
    this.#viewpoint()?.turn(yaw, pitch);
  }

  /** Multiply the distance to the target. */
  zoom(factor: number): void {
    this.#viewpoint()?.zoom(factor);
  }

  /** Move so that the target follows a drag, CSS pixels. */
  pan(dx: number, dy: number): void {
    this.#viewpoint()?.pan(dx, dy);
  }

  /** Turn the camera about itself: to its left and upwards, radians. */
  lookAround(yaw: number, pitch: number): void {
    this.#viewpoint()?.lookAround(yaw, pitch);
  }

  /** Move to the right, upwards and ahead, by shares of the first distance to the target. */
  travel(right: number, up: number, ahead: number): void {
    this.#viewpoint()?.travel(right, up, ahead);
  }

  /** Let a camera outside the captured space spring back. */
  release(): void {
    this.#viewpoint()?.release();
  }

  /**
   * Look at the scene's point at a place of the picture, CSS pixels from its top left corner, and turn about it from
   * now on.
   */
  focus(x: number, y: number): void {
    this.#viewpoint()?.focus(x, y);
  }

  /** Return to the capture camera of the first view. */
  reset(): void {
    this.#viewpoint()?.reset();
  }
}
