/** The camera as drags and keys move it: they turn it about the scene, or look around while it flies. */

import type { FlyMode } from "../camera/fly_mode";
import type { CameraMotion } from "../camera/gestures";

/** A camera that can do both. */
export interface SteeredCamera extends CameraMotion {
  /** To its left and upwards, radians. */
  lookAround(yaw: number, pitch: number): void;
}

/** In both ways what is seen follows the hand. */
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
