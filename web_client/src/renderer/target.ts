/** An off-screen float picture: without the rounding of an 8-bit canvas, for comparisons with reference pictures. */

export class FloatTarget {
  readonly #texture: WebGLTexture;
  readonly #framebuffer: WebGLFramebuffer;

  /**
   * Create the target and bind it.
   *
   * @throws Error if the device renders to no float format.
   */
  constructor(
    readonly gl: WebGL2RenderingContext,
    readonly width: number,
    readonly height: number,
  ) {
    if (!gl.getExtension("EXT_color_buffer_float")) throw new Error("this device cannot draw into float textures");
    const format = gl.getExtension("EXT_float_blend") ? gl.RGBA32F : gl.RGBA16F;
    this.#texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
    this.#framebuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.#framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.#texture, 0);
  }

  /** RGBA, rows from the bottom. */
  read(): Float32Array {
    const data = new Float32Array(4 * this.width * this.height);
    this.gl.readPixels(0, 0, this.width, this.height, this.gl.RGBA, this.gl.FLOAT, data);
    return data;
  }

  dispose(): void {
    this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, null);
    this.gl.deleteFramebuffer(this.#framebuffer);
    this.gl.deleteTexture(this.#texture);
  }
}
