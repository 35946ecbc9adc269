/** What splats are drawn into when a host draws with them, such as an engine with meshes of its own. */

import { type Uniforms, uniformsOf } from "../renderer/program";
import type { SplatSurroundings } from "../renderer/splat_drawer";

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

const DECLARATIONS = `
uniform vec4 depthZ;          // these take a point before the camera, and 1, to the host's clip-space z and w
uniform vec4 depthW;
uniform float logarithmic;    // what the host multiplies logarithms of depth by; 0 if its depth has none
uniform bool linear;          // whether colours are wanted in linear light
`;

const STATEMENTS = `
  float clipW = dot(depthW, vec4(p, 1.0));
  gl_Position.z = logarithmic > 0.0 ? logarithmic * log2(1.0 + clipW) - 1.0 : dot(depthZ, vec4(p, 1.0)) / clipW;
  if (linear) {
    vec3 steep = pow((max(paint.rgb, 0.0) + 0.055) / 1.055, vec3(2.4));
    colour.rgb = mix(paint.rgb / 12.92, steep, step(0.04045, paint.rgb));
  }
`;

const UNIFORMS = ["depthZ", "depthW", "logarithmic", "linear"] as const;

/** Draws splats among a host's surfaces: behind what is nearer, without a depth of their own, in the host's light. */
export class HostSurroundings implements SplatSurroundings {
  readonly declarations = DECLARATIONS;
  readonly statements = STATEMENTS;
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
