/** A data texture of splats, filled chunk by chunk. */

import { TEXTURE_WIDTH } from "./layout";

export class SplatTexture {
  #texture: WebGLTexture | null = null;
  #rows = 1;
  #filled = false;

  constructor(
    readonly what: string,
    readonly width = TEXTURE_WIDTH,
  ) {}

  /** Whether anything was written since the allocation. */
  get filled(): boolean {
    return this.#filled;
  }

  /** Bytes on the device. */
  get bytes(): number {
    return this.#texture ? 16 * this.width * this.#rows : 0;
  }

  /**
   * Make room for `rows` rows, empty.
   *
   * @throws Error if the device supports no such texture; for a lost context, at its restoration.
   */
  allocate(gl: WebGL2RenderingContext, rows: number): void {
    this.#rows = Math.max(1, rows);
    this.#filled = false;
    this.create(gl);
  }

  /** Write whole rows of texels, in sequence, to these rows of the texture. */
  write(gl: WebGL2RenderingContext, rows: readonly number[], texels: Float32Array): void {
    if (texels.length === 0) return;
    this.#filled = true;
    const row = 4 * this.width;
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
    for (let i = 0; i < rows.length; ) {
      let end = i + 1;
      while (end < rows.length && rows[end] === rows[end - 1] + 1) end++;
      const part = texels.subarray(i * row, end * row);
      gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, rows[i], this.width, end - i, gl.RGBA, gl.FLOAT, part);
      i = end;
    }
  }

  /** Create the texture, empty. */
  create(gl: WebGL2RenderingContext): void {
    if (gl.isContextLost()) return; // created again at the restoration
    const most = gl.getParameter(gl.MAX_TEXTURE_SIZE) as number;
    if (this.#rows > most) {
      throw new Error(`this device holds ${most} rows of ${this.what} splats, and the scene has ${this.#rows}`);
    }
    gl.deleteTexture(this.#texture);
    this.#texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, this.width, this.#rows);
  }

  /** Forget the texture of a lost context. */
  forget(): void {
    this.#texture = null;
  }

  bind(gl: WebGL2RenderingContext, unit: number): void {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
  }

  dispose(gl: WebGL2RenderingContext): void {
    gl.deleteTexture(this.#texture);
    this.#texture = null;
    this.#filled = false;
  }
}
