/** The fading of static splats on a page, before a soft background. */

import { stillShare } from "../camera/cones";
import type { Manifest } from "../codec/types";
import type { CanvasRenderer } from "../renderer/canvas_renderer";
import { SoftBackground } from "../renderer/soft_background";
import type { StreamedScene } from "../scene/streamed_scene";

/** Fade from now on; once for a renderer. */
export function fade(scene: StreamedScene, renderer: CanvasRenderer, manifest: Manifest): void {
  if (renderer.backdrop) return;
  scene.still = stillShare(manifest);
  const background = new SoftBackground(renderer.splats.gl, manifest);
  renderer.canvas.addEventListener("webglcontextrestored", () => background.forget());
  renderer.backdrop = (shot) => background.draw(shot);
}
