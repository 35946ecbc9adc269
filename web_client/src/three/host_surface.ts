/** What splats are drawn into when a host draws with them, such as an engine with meshes of its own. */

import { type Uniforms, uniformsOf } from "../renderer/program";
import type { SplatSurroundings } from "../renderer/splat_drawer";
import shader from "./host_surface.vert?raw";

type Row = readonly [number, number, number, number];

export interface HostSurface {
  /**
   * Two rows of a matrix that takes a point before the camera (OpenCV axes, the scene's units, then 1) to the host's clip
   * space: its z and its w. A splat has the depth of its centre all over.
   */
  readonly z: Row;
  readonly w: Row;
  /** 2 / log2(far + 1) where the host writes depth as log2(1 + w) / log2(far + 1); else 0. */
  readonly logarithmic: number;
  /** Whether what is near has the greater depth. */
  readonly reversed: boolean;
  /** Whether colours are written in linear light; else in sRGB, as they are. */
  readonly linear: boolean;
}

const UNIFORMS = ["depthZ", "depthW", "logarithmic", "linear"] as const;

/** Draws splats among a host's surfaces: behind what is nearer, without a depth of their own, in the host's light. */
export class HostSurroundings implements SplatSurroundings {
  readonly shader = shader;
  /** What the next picture is drawn into; to be set before it. */
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
  }
}
