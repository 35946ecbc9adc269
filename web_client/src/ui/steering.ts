/** Steering by drags and keys: they turn the camera about the scene, or, in flight, about itself. */

import type { FlyMode } from "../camera/fly_mode";
import type { CameraMotion } from "../camera/gestures";

/** A camera for both. */
export interface SteeredCamera extends CameraMotion {
  /** Turn to its left and upwards, radians. */
  lookAround(yaw: number, pitch: number): void;
}

/** The steering; in both modes the picture follows the hand. */
export function steering(camera: SteeredCamera, fly: Pick<FlyMode, "active">): CameraMotion {
  return {
    turn: (yaw, pitch) => {
      if (fly.active) camera.lookAround(yaw, pitch);
      else camera.turn(yaw, pitch);
    },
    zoom: (factor) => camera.zoom(factor),
    pan: (dx, dy) => camera.pan(dx, dy),
    release: () => camera.release(),
    focus: (x, y) => camera.focus(x, y),
  };
}
