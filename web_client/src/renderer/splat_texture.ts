/** A data texture of splats, filled chunk by chunk, with a copy in memory from which a lost context is restored. */

import { TEXTURE_WIDTH } from "./layout";

export class SplatTexture {
  #texture: WebGLTexture | null = null;
  #rows = 1;
  #chunks: { row: number; texels: Float32Array }[] = [];

  constructor(
    readonly what: string,
    readonly width = TEXTURE_WIDTH,
  ) {}

  /** Whether anything was written since room was made. */
  get filled(): boolean {
    return this.#chunks.length > 0;
  }

  /** Make room for `rows` rows, empty. */
  allocate(gl: WebGL2RenderingContext, rows: number): void {
    const most = gl.getParameter(gl.MAX_TEXTURE_SIZE) as number;
    if (rows > most) {
      throw new Error(`this device holds ${most} rows of ${this.what} splats, and the scene has ${rows}`);
    }
    this.#rows = Math.max(1, rows);
    this.#chunks = [];
    this.create(gl);
  }

  /** Write whole rows, beginning with `row`. The texels are kept. */
  write(gl: WebGL2RenderingContext, row: number, texels: Float32Array): void {
    if (texels.length === 0) return;
    this.#chunks.push({ row, texels });
    this.#upload(gl, row, texels);
  }

  /** Create the texture anew and fill it with all that was written. */
  create(gl: WebGL2RenderingContext): void {
    gl.deleteTexture(this.#texture);
    this.#texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, this.width, this.#rows);
    for (const { row, texels } of this.#chunks) this.#upload(gl, row, texels);
  }

  bind(gl: WebGL2RenderingContext, unit: number): void {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
  }

  /** Delete the texture and let go of what was written. */
  dispose(gl: WebGL2RenderingContext): void {
    gl.deleteTexture(this.#texture);
    this.#texture = null;
    this.#chunks = [];
  }

  #upload(gl: WebGL2RenderingContext, row: number, texels: Float32Array): void {
    const rows = texels.length / (4 * this.width);
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, row, this.width, rows, gl.RGBA, gl.FLOAT, texels);
  }
}
