/**
 * The conversion of a target's linear light: splats are blended as sRGB, so the target's contents are converted to sRGB
 * before splats are drawn, and back afterwards. Splats then look as on a canvas, and everything behind them is
 * unchanged.
 */

import type { Viewport } from "../camera/projection";
import presentVertexShader from "../renderer/present.vert?raw";
import { Program } from "../renderer/program";
import convertFragmentShader from "./linear_light.frag?raw";

/** A format of colours that is fine enough for conversions in both directions. */
export type FineFormat = "RGBA16F" | "RGBA32F";

export class LinearLight {
  readonly #gl: WebGL2RenderingContext;
  readonly #program: Program<"picture" | "linear" | "exponent">;
  readonly #vertices: WebGLVertexArrayObject;
  readonly #framebuffer: WebGLFramebuffer;
  #texture: WebGLTexture | null = null;
  #size = "";

  constructor(gl: WebGL2RenderingContext) {
    this.#gl = gl;
    this.#program = new Program(gl, presentVertexShader, convertFragmentShader, ["picture", "linear", "exponent"]);
    this.#vertices = gl.createVertexArray();
    this.#framebuffer = gl.createFramebuffer();
  }

  /**
   * Run a function that draws sRGB into the bound framebuffer, which holds linear light in that format before and
   * after; see `HostSurface.exponent`.
   */
  around(viewport: Viewport, format: FineFormat, exponent: number, draw: () => void): void {
    this.#convert(viewport, format, exponent, false);
    draw();
    this.#convert(viewport, format, exponent, true);
  }

  dispose(): void {
    this.#program.dispose();
    this.#gl.deleteVertexArray(this.#vertices);
    this.#gl.deleteFramebuffer(this.#framebuffer);
    this.#gl.deleteTexture(this.#texture);
  }

  /**
   * Convert the target. Leaves depth test and blending on, as the drawer and the host have them; binds texture unit 0.
   */
  #convert({ x, y, width, height }: Viewport, format: FineFormat, exponent: number, linear: boolean): void {
    const gl = this.#gl;
    const target = gl.getParameter(gl.DRAW_FRAMEBUFFER_BINDING);
    const read = gl.getParameter(gl.READ_FRAMEBUFFER_BINDING);
    const scissor = gl.isEnabled(gl.SCISSOR_TEST);
    const [right, top] = [x + width, y + height];
    this.#make(right, top, format);
    gl.disable(gl.SCISSOR_TEST); // otherwise it cuts the copy
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, target);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, this.#framebuffer);
    gl.flush(); // otherwise SwiftShader now and then copies the contents before the host's clearing
    // To the same place: multisampled pixels cannot be copied elsewhere.
    gl.blitFramebuffer(x, y, right, top, x, y, right, top, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, read);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, target);
    if (scissor) gl.enable(gl.SCISSOR_TEST);
    gl.disable(gl.BLEND);
    gl.disable(gl.DEPTH_TEST);
    gl.viewport(x, y, width, height);
    gl.useProgram(this.#program.handle);
    gl.bindVertexArray(this.#vertices);
    gl.uniform1i(this.#program.uniforms.picture, 0);
    gl.uniform1i(this.#program.uniforms.linear, linear ? 1 : 0);
    gl.uniform1f(this.#program.uniforms.exponent, exponent);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.enable(gl.BLEND);
    gl.enable(gl.DEPTH_TEST);
  }

  /** Make room for a copy, bound to texture unit 0. */
  #make(width: number, height: number, format: FineFormat): void {
    const gl = this.#gl;
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
    const size = `${width} ${height} ${format}`;
    if (this.#size === size) return;
    this.#size = size;
    gl.deleteTexture(this.#texture);
    this.#texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl[format], width, height);
    const bound = gl.getParameter(gl.DRAW_FRAMEBUFFER_BINDING);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, this.#framebuffer);
    gl.framebufferTexture2D(gl.DRAW_FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.#texture, 0);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, bound);
  }
}
