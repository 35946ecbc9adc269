/** An off-screen target for pictures of splats. */

export type PixelFormat = "RGBA8" | "RGBA16F" | "RGBA32F";

/** Whether the device draws and blends into textures of half floats. */
export const drawsHalfFloats = (gl: WebGL2RenderingContext): boolean =>
  gl.getExtension("EXT_color_buffer_float") !== null || gl.getExtension("EXT_color_buffer_half_float") !== null;

export class PictureTarget {
  readonly #gl: WebGL2RenderingContext;
  readonly #texture: WebGLTexture;
  readonly #framebuffer: WebGLFramebuffer;

  /** Create the picture and bind it. The device must be able to draw into the format. */
  constructor(
    gl: WebGL2RenderingContext,
    readonly width: number,
    readonly height: number,
    readonly format: PixelFormat,
  ) {
    this.#gl = gl;
    this.#texture = gl.createTexture();
    this.bindTexture(0);
    // Eight bits are for pictures that are enlarged.
    const filter = format === "RGBA8" ? gl.LINEAR : gl.NEAREST;
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl[format], width, height);
    this.#framebuffer = gl.createFramebuffer();
    this.bind();
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.#texture, 0);
  }

  /** Bind it as the target of drawing. */
  bind(): void {
    this.#gl.bindFramebuffer(this.#gl.FRAMEBUFFER, this.#framebuffer);
  }

  /** Bind the picture for reading in shaders. */
  bindTexture(unit: number): void {
    this.#gl.activeTexture(this.#gl.TEXTURE0 + unit);
    this.#gl.bindTexture(this.#gl.TEXTURE_2D, this.#texture);
  }

  dispose(): void {
    this.#gl.bindFramebuffer(this.#gl.FRAMEBUFFER, null);
    this.#gl.deleteFramebuffer(this.#framebuffer);
    this.#gl.deleteTexture(this.#texture);
  }
}
