/** The background in place of static splats that fade: a gradient between the scene's own colour and grey. */

import { add, apply, scale, type Vec3 } from "../camera/vector";
import type { Manifest } from "../codec/types";
import { Program } from "./program";
import type { Shot } from "./shot";
import fragmentShader from "./soft_background.frag?raw";
import vertexShader from "./soft_background.vert?raw";

const UNIFORMS = ["below", "level", "above", "up", "lens"] as const;

const GREY: Vec3 = [0.5, 0.5, 0.5];
/** Shares of grey: a black void would look like a failure, and a line at the horizon like a floor. */
const SHARES = { below: 0.3, level: 0.45, above: 0.2 };

export class SoftBackground {
  #program: Program<(typeof UNIFORMS)[number]> | null = null;

  constructor(
    readonly gl: WebGL2RenderingContext,
    readonly manifest: Pick<Manifest, "up" | "background">,
  ) {}

  /** Forget the program of a lost context. */
  forget(): void {
    this.#program = null;
  }

  /** Cover the bound target, by as much as static splats have faded. */
  draw({ pose, camera, still = 1 }: Shot): void {
    if (still === 1) return;
    const { gl } = this;
    const { background, up } = this.manifest;
    this.#program ??= new Program(gl, vertexShader, fragmentShader, UNIFORMS);
    const { handle, uniforms } = this.#program;
    gl.viewport(0, 0, camera.width, camera.height);
    gl.disable(gl.BLEND);
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
    gl.useProgram(handle);
    for (const name of ["below", "level", "above"] as const) {
      const share = SHARES[name] * (1 - still);
      gl.uniform3f(uniforms[name], ...add(scale(background, 1 - share), scale(GREY, share)));
    }
    gl.uniform3f(uniforms.up, ...apply(pose.rotation, up));
    gl.uniform4f(uniforms.lens, camera.fx, camera.fy, camera.cx, camera.height - camera.cy);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
}
