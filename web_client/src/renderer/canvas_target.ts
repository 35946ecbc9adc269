/** The target of drawing: the canvas itself, or a picture in half floats or with fewer pixels that is copied to it. */

import type { Fineness } from "./fineness";
import { drawsHalfFloats, PictureTarget } from "./picture_target";
import presentFragmentShader from "./present.frag?raw";
import presentVertexShader from "./present.vert?raw";
import { Program } from "./program";

export interface DrawnSize {
  readonly width: number;
  readonly height: number;
}

export class CanvasTarget {
  readonly #gl: WebGL2RenderingContext;
  readonly #program: Program<"picture" | "size">;
  readonly #float: boolean;
  #picture: PictureTarget | null = null;

  /** Create the target, again after a restoration of the context. */
  constructor(gl: WebGL2RenderingContext) {
    this.#gl = gl;
    this.#float = drawsHalfFloats(gl);
    this.#program = new Program(gl, presentVertexShader, presentFragmentShader, ["picture", "size"]);
  }

  /** Set the canvas's size and bind the target; returns the size at which to draw. */
  begin(width: number, height: number, { scale, float }: Fineness): DrawnSize {
    const { canvas } = this.#gl;
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    const format = float && this.#float ? "RGBA16F" : "RGBA8";
    if (scale < 1 || format === "RGBA16F")
      return this.#use(Math.ceil(width * scale), Math.ceil(height * scale), format);
    this.#drop();
    this.#gl.bindFramebuffer(this.#gl.FRAMEBUFFER, null);
    return { width, height };
  }

  /** Copy the picture to the canvas, and leave the canvas bound. */
  end(): void {
    if (!this.#picture) return; // the canvas was the target
    const gl = this.#gl;
    const { width, height } = gl.canvas;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, width, height);
    gl.useProgram(this.#program.handle);
    gl.uniform1i(this.#program.uniforms.picture, 0);
    gl.uniform2f(this.#program.uniforms.size, width, height);
    this.#picture.bindTexture(0);
    gl.disable(gl.BLEND);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  #use(width: number, height: number, format: "RGBA8" | "RGBA16F"): DrawnSize {
    const picture = this.#picture;
    if (picture?.width !== width || picture.height !== height || picture.format !== format) {
      this.#drop();
      this.#picture = new PictureTarget(this.#gl, width, height, format);
    } else {
      picture.bind();
    }
    return { width, height };
  }

  #drop(): void {
    this.#picture?.dispose();
    this.#picture = null;
  }
}
