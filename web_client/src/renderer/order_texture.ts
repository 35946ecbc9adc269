/** The ids of the splats to draw, farthest first, in an R32UI texture that grows as needed. */

import { TEXTURE_WIDTH } from "./layout";

export class OrderTexture {
  #texture: WebGLTexture | null = null;
  #rows = 0;

  /** Bytes on the device. */
  get bytes(): number {
    return 4 * TEXTURE_WIDTH * this.#rows;
  }

  /** Upload the first `count` ids. `ids` is whole rows long. */
  write(gl: WebGL2RenderingContext, ids: Uint32Array, count: number): void {
    if (gl.isContextLost()) return; // another order follows the restoration
    const rows = Math.ceil(count / TEXTURE_WIDTH);
    if (rows > this.#rows || !this.#texture) {
      gl.deleteTexture(this.#texture);
      this.#rows = Math.max(1, rows, Math.ceil(this.#rows * 1.5));
      this.#texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, this.#texture);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
      gl.texStorage2D(gl.TEXTURE_2D, 1, gl.R32UI, TEXTURE_WIDTH, this.#rows);
    }
    if (rows === 0) return;
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, TEXTURE_WIDTH, rows, gl.RED_INTEGER, gl.UNSIGNED_INT, ids);
  }

  bind(gl: WebGL2RenderingContext, unit: number): void {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
  }

  dispose(gl: WebGL2RenderingContext): void {
    gl.deleteTexture(this.#texture);
    this.forget();
  }

  /** Forget the texture of a lost context. */
  forget(): void {
    this.#texture = null;
    this.#rows = 0;
  }
}
