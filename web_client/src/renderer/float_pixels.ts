/** Pictures in floats, for comparisons: the canvas rounds. */

import { type CanvasRenderer, flipped } from "./canvas_renderer";
import { drawsHalfFloats, PictureTarget } from "./picture_target";
import type { Pixels, Shot } from "./shot";

/**
 * Draw into a 32-bit float picture (16-bit where the device cannot blend 32) and read it.
 *
 * @throws Error if the device draws to no float format.
 */
export function floatPixels(renderer: CanvasRenderer, shot: Shot): Pixels {
  const { gl } = renderer.splats;
  const { width, height } = shot.camera;
  const whole = gl.getExtension("EXT_color_buffer_float") && gl.getExtension("EXT_float_blend");
  const format = whole ? "RGBA32F" : "RGBA16F";
  if (!whole && !drawsHalfFloats(gl)) throw new Error("this device cannot draw into float textures");
  const target = new PictureTarget(gl, width, height, format);
  try {
    renderer.fill(shot);
    const data = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, data);
    return { width, height, data: flipped(data, width, height) };
  } finally {
    target.dispose();
  }
}
