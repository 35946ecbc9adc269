/** The fading of static splats on a page, before a soft background. */

import { stillShare } from "../camera/cones";
import { MotionLoop } from "../camera/motion_loop";
import type { Manifest } from "../codec/types";
import type { CanvasRenderer } from "../renderer/canvas_renderer";
import { SoftBackground } from "../renderer/soft_background";
import type { StreamedScene } from "../scene/streamed_scene";

/** The canvas of a scene. */
export interface SwitchedCanvas {
  readonly renderer: CanvasRenderer;
  readonly subjectOnly: boolean;
  /** A frame is due. */
  invalidate(): void;
}

/** Duration of a visitor's switch, seconds. */
const DURATION = 0.35;

/** The shares of static splats shown in the middle of a switch. */
const switching = new WeakMap<CanvasRenderer, number>();

/** Fade from now on; once for a renderer. */
export function fade(scene: StreamedScene, renderer: CanvasRenderer, manifest: Manifest): void {
  if (renderer.backdrop) return;
  scene.still = stillShare(manifest);
  scene.shown = () => {
    const shown = switching.get(renderer) ?? Number(!scene.subjectOnly);
    return shown * shown * (3 - 2 * shown);
  };
  const background = new SoftBackground(renderer.splats.gl, manifest);
  renderer.canvas.addEventListener("webglcontextrestored", () => background.forget());
  renderer.backdrop = (shot) => background.draw(shot);
}

/** Let the static splats fade or come back that a visitor has just switched; at once where less motion is wanted. */
export function showSwitch(canvas: SwitchedCanvas, signal: AbortSignal): void {
  const { renderer } = canvas;
  if (switching.has(renderer) || matchMedia("(prefers-reduced-motion: reduce)").matches) return;
  let shown = Number(canvas.subjectOnly);
  switching.set(renderer, shown);
  new MotionLoop(signal).run((seconds) => {
    const step = seconds / DURATION;
    shown = canvas.subjectOnly ? Math.max(0, shown - step) : Math.min(1, shown + step);
    switching.set(renderer, shown);
    if (shown === Number(!canvas.subjectOnly)) switching.delete(renderer);
    canvas.invalidate();
    return switching.has(renderer);
  });
}
