/** The drawer of flat objects over the splats of an eye: the panel with its picture, and thin rays, without depth. */

import { add, cross, length, normalise, scale, subtract, type Vec3 } from "../camera/vector";
import { Program } from "../renderer/program";
import fragmentShader from "./flat.frag?raw";
import vertexShader from "./flat.vert?raw";

/** A rectangle in the room: a corner, and the sides from there. */
export interface Quad {
  readonly corner: Vec3;
  readonly along: Vec3;
  readonly up: Vec3;
}

/** WebXR's matrices of an eye, by columns. */
export interface EyeMatrices {
  readonly projection: Float32Array;
  readonly eyeFromRoom: Float32Array;
}

/** sRGB and alpha. */
export type Colour = readonly [number, number, number, number];

export class FlatDrawer {
  readonly #program: Program<"clip" | "picture" | "colour">;
  readonly #texture: WebGLTexture;

  constructor(readonly gl: WebGL2RenderingContext) {
    this.#program = new Program(gl, vertexShader, fragmentShader, ["clip", "picture", "colour"]);
    this.#texture = gl.createTexture();
    this.#bind();
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  }

  /** Take a new picture for the panel. */
  upload(picture: HTMLCanvasElement): void {
    const { gl } = this;
    this.#bind();
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, true);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, true);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, picture);
    gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, false); // the splats' textures require it
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.generateMipmap(gl.TEXTURE_2D);
  }

  /** Draw a rectangle into the current viewport: in one colour, or with the panel's picture. */
  draw({ corner, along, up }: Quad, { projection, eyeFromRoom }: EyeMatrices, colour?: Colour): void {
    const { gl } = this;
    const roomFromQuad = [...along, 0, ...up, 0, 0, 0, 0, 0, ...corner, 1];
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
    gl.useProgram(this.#program.handle);
    this.#bind();
    gl.uniform1i(this.#program.uniforms.picture, 0);
    gl.uniformMatrix4fv(this.#program.uniforms.clip, false, product(projection, product(eyeFromRoom, roomFromQuad)));
    const [r, g, b, a] = colour ?? [0, 0, 0, 0];
    gl.uniform4f(this.#program.uniforms.colour, r * a, g * a, b * a, a);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  }

  dispose(): void {
    this.#program.dispose();
    this.gl.deleteTexture(this.#texture);
  }

  #bind(): void {
    this.gl.activeTexture(this.gl.TEXTURE0);
    this.gl.bindTexture(this.gl.TEXTURE_2D, this.#texture);
  }
}

/** A ribbon from `from` to `to`, `width` metres wide, with its face towards `eye`. */
export function ribbon(from: Vec3, to: Vec3, width: number, eye: Vec3): Quad {
  const up = subtract(to, from);
  const side = cross(up, subtract(eye, from));
  const along = scale(length(side) > 1e-9 ? normalise(side) : [1, 0, 0], width);
  return { corner: add(from, scale(along, -0.5)), along, up };
}

/** a b, 4x4 by columns. */
function product(a: ArrayLike<number>, b: ArrayLike<number>): Float32Array {
  const out = new Float32Array(16);
  for (let column = 0; column < 4; column++) {
    for (let line = 0; line < 4; line++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[4 * k + line] * b[4 * column + k];
      out[4 * column + line] = sum;
    }
  }
  return out;
}
