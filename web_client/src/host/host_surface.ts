/** The surface that a host, such as an engine with meshes of its own, draws splats into. */

import { type Uniforms, uniformsOf } from "../renderer/program";
import type { SplatSurroundings } from "../renderer/splat_drawer";
import shader from "./host_surface.vert?raw";

type Row = readonly [number, number, number, number];

export interface HostSurface {
  /**
   * Two rows of a matrix from camera space (OpenCV axes, the scene's units, then 1) to the host's clip space: its z and
   * its w. All pixels of a splat have the depth of its centre.
   */
  readonly z: Row;
  readonly w: Row;
  /** 2 / log2(far + 1) if the host writes depth as log2(1 + w) / log2(far + 1); else 0. */
  readonly logarithmic: number;
  /** Whether nearer points have greater depths. */
  readonly reversed: boolean;
  /** Whether colours are written in linear light; otherwise in sRGB, unchanged. */
  readonly linear: boolean;
  /** The exponent that the host's materials take for the curve from colours to linear light; 0 for that of sRGB. */
  readonly exponent: number;
}

const UNIFORMS = ["depthZ", "depthW", "logarithmic", "linear", "exponent"] as const;

/**
 * A host's surroundings of splats: nearer surfaces hide them, they write no depth, and their colours are in the host's
 * light.
 */
export class HostSurroundings implements SplatSurroundings {
  readonly shader = shader;
  /** The surface of the next picture; to be set before it. */
  surface!: HostSurface;
  #uniforms!: Uniforms<(typeof UNIFORMS)[number]>;

  linked(gl: WebGL2RenderingContext, program: WebGLProgram): void {
    this.#uniforms = uniformsOf(gl, program, UNIFORMS);
  }

  prepare(gl: WebGL2RenderingContext): void {
    const { surface } = this;
    const u = this.#uniforms;
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(surface.reversed ? gl.GEQUAL : gl.LEQUAL);
    gl.depthMask(false);
    gl.uniform4f(u.depthZ, ...surface.z);
    gl.uniform4f(u.depthW, ...surface.w);
    gl.uniform1f(u.logarithmic, surface.logarithmic);
    gl.uniform1i(u.linear, surface.linear ? 1 : 0);
    gl.uniform1f(u.exponent, surface.exponent);
  }
}
