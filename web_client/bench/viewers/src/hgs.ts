/** Our own player, as a page has it; a still camera costs it nothing, so that every frame here is asked for. */

import { eyeOf } from "../../../src/camera/pinhole";
import type { Mat3, Vec3 as Vector } from "../../../src/camera/vector";
import { SceneCanvas } from "../../../src/player/scene_canvas";
import { CanvasRenderer } from "../../../src/renderer/canvas_renderer";
import type { Quality } from "../../../src/renderer/fineness";
import { openSource } from "../../../src/source/open_source";
import { type BenchCamera, canvasOf, type OpenViewer } from "./viewer";

/** The bench waits for the device itself. */
Object.defineProperty(CanvasRenderer.prototype, "busy", { value: () => false });

function viewOf({ eye, target, up, fovY, near }: BenchCamera, width: number, height: number) {
  const minus = (a: Vector, b: Vector): Vector => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const unit = (a: Vector): Vector => {
    const length = Math.hypot(...a);
    return [a[0] / length, a[1] / length, a[2] / length];
  };
  const cross = (a: Vector, b: Vector): Vector => [
    a[1] * b[2] - a[2] * b[1],
    a[2] * b[0] - a[0] * b[2],
    a[0] * b[1] - a[1] * b[0],
  ];
  const forward = unit(minus(target, eye));
  const right = unit(cross(forward, up));
  const rotation: Mat3 = [...right, ...cross(forward, right), ...forward];
  const towards = eyeOf({ rotation: transposed(rotation), translation: eye });
  const focal = (0.5 * height) / Math.tan((fovY * Math.PI) / 360);
  const camera = { width, height, fx: focal, fy: focal, cx: width / 2, cy: height / 2, near };
  return { pose: { rotation, translation: towards }, camera };
}

const transposed = (m: Mat3): Mat3 => [m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]];

/** @param share of the scene's splats that are drawn at most. */
export const openHgs =
  (quality: Quality, share = Number.POSITIVE_INFINITY): OpenViewer =>
  async (request) => {
    const canvas = canvasOf(request);
    let { camera } = request;
    let nudge = 0;
    const player = new SceneCanvas({
      canvas,
      source: openSource(new URL("scene/manifest.json", request.files).href),
      time: null,
      playing: false,
      antialiased: null,
      view: () => {
        const view = viewOf(camera, request.width, request.height);
        return { ...view, camera: { ...view.camera, fx: view.camera.fx + nudge } };
      },
      onManifest: () => {
        if (player.playback) player.playback.clock.loop = true;
      },
      onFrame: () => {},
      onError: (_, cause) => {
        throw new Error(cause);
      },
    });
    player.quality = quality;
    player.splatBudget = share * request.splats;
    return {
      gl: canvas.getContext("webgl2") as WebGL2RenderingContext,
      look: (next) => {
        camera = next;
        player.invalidate();
      },
      draw: () => {
        nudge = nudge === 0 ? 5e-7 : 0; // a billionth of a pixel: another view, the same picture
        player.invalidate();
      },
      busy: () => !player.stats.complete || player.stats.firstFrame === null,
      play: (playing) => {
        if (playing) player.playback?.play();
        else player.playback?.pause();
        player.invalidate();
      },
    };
  };
