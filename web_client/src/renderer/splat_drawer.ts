/**
 * The splats of one scene in one WebGL2 context: data textures, order, and the program that draws them into the bound
 * framebuffer. It needs no canvas, so it serves a page's own context, a host's and a headset's.
 */

import { magnification } from "../camera/magnification";
import { FIFTH_WIDTH, LAYOUT_DEFINITIONS, STATICS_PER_ROW, TEXTURE_WIDTH, TRIANGLES_PER_INSTANCE } from "./layout";
import { OrderTexture } from "./order_texture";
import { Program } from "./program";
import type { Shot } from "./shot";
import fragmentShader from "./splat.frag?raw";
import vertexShader from "./splat.vert?raw";
import { SplatTexture } from "./splat_texture";

const UNIFORMS = [
  "statics",
  "dynamics",
  "fifth",
  "order",
  "count",
  "rotation",
  "translation",
  "focal",
  "centre",
  "size",
  "origin",
  "time",
  "near",
  "antialiased",
  "magnification",
  "still",
  "closeUp",
  "depths",
] as const;

/** Larger than any deviation, pixels. */
const LARGEST = 1e9;

/** Texture rows that every device with WebGL2 supports. */
export const FEWEST_ROWS = 2048;

/** The receiver of a scene's decoded splats and of their order. */
export interface SplatSink {
  /** Texture rows that this device supports. */
  readonly mostRows: number;
  /** Make room for a scene; `staticRows` and `dynamicRows` are texture rows. */
  allocate(staticRows: number, dynamicRows: number): void;
  /** Write packed static splats; `first` is the id of the first, at the start of a row. */
  writeStatics(first: number, texels: Float32Array): void;
  /** Write packed dynamic splats into these rows, in sequence. `fifth` may be empty. */
  writeDynamics(rows: readonly number[], texels: Float32Array, fifth: Float32Array): void;
  /** Set the order of drawing: `count` ids, farthest first, in an array of whole texture rows. */
  setOrder(ids: Uint32Array, count: number): void;
}

/** The differences where splats are drawn among other things. */
export interface SplatSurroundings {
  /** GLSL that defines `surround`: see splat.vert. */
  readonly shader: string;
  /** The program has been linked, for the first time or again. */
  linked(gl: WebGL2RenderingContext, program: WebGLProgram): void;
  /** Splats are about to be drawn; the program is in use, and the depth test is off. */
  prepare(gl: WebGL2RenderingContext): void;
}

export class SplatDrawer implements SplatSink {
  readonly #statics = new SplatTexture("static");
  readonly #dynamics = new SplatTexture("dynamic");
  readonly #fifth = new SplatTexture("dynamic", FIFTH_WIDTH);
  readonly #order = new OrderTexture();
  #program: Program<(typeof UNIFORMS)[number]> | undefined;
  #vertices!: WebGLVertexArrayObject; // no attributes: the shader reads textures
  #dynamicRows = 0;
  #mostRows = FEWEST_ROWS;
  #count = 0;

  constructor(
    readonly gl: WebGL2RenderingContext,
    readonly surroundings?: SplatSurroundings,
  ) {
    this.rebuild();
  }

  get mostRows(): number {
    return this.#mostRows;
  }

  /** Memory for splats and order on the device, bytes. */
  get bytes(): number {
    const textures = [this.#statics, this.#dynamics, this.#fifth, this.#order];
    return textures.reduce((sum, { bytes }) => sum + bytes, 0);
  }

  /** Splats in the current order. */
  get count(): number {
    return this.#count;
  }

  allocate(staticRows: number, dynamicRows: number): void {
    this.#statics.allocate(this.gl, staticRows);
    this.#dynamics.allocate(this.gl, dynamicRows);
    this.#fifth.allocate(this.gl, 0);
    this.#dynamicRows = dynamicRows;
  }

  writeStatics(first: number, texels: Float32Array): void {
    const row = first / STATICS_PER_ROW;
    const rows = texels.length / (4 * TEXTURE_WIDTH);
    const all = Array.from({ length: rows }, (_, i) => row + i);
    this.#statics.write(this.gl, all, texels);
  }

  writeDynamics(rows: readonly number[], texels: Float32Array, fifth: Float32Array): void {
    this.#dynamics.write(this.gl, rows, texels);
    if (fifth.length === 0) return;
    if (!this.#fifth.filled) this.#fifth.allocate(this.gl, this.#dynamicRows);
    this.#fifth.write(this.gl, rows, fifth);
  }

  setOrder(ids: Uint32Array, count: number): void {
    this.#order.write(this.gl, ids, count);
    this.#count = count;
  }

  /** Create everything again in a restored context; then the splats and an order must be set again. */
  rebuild(): void {
    const { gl, surroundings } = this;
    if (gl.isContextLost()) return; // called again after the restoration
    this.#mostRows = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    const more = surroundings ? "#define SURROUNDED\n" : "";
    const vertices = vertexShader.replace("\n", LAYOUT_DEFINITIONS + more) + (surroundings?.shader ?? "");
    this.#program = new Program(gl, vertices, fragmentShader, UNIFORMS);
    surroundings?.linked(gl, this.#program.handle);
    this.#vertices = gl.createVertexArray();
    this.#order.forget();
    this.#count = 0;
    for (const texture of [this.#statics, this.#dynamics, this.#fifth]) {
      texture.forget();
      texture.create(gl);
    }
  }

  /**
   * Blend the splats over the bound framebuffer, in the rectangle of the camera's size with the lower left corner
   * `origin`, in pixels of that framebuffer. Only the surroundings may use depth. With `paint` "depth" each channel of
   * a splat's colour is the depth of its centre.
   */
  draw(
    { pose, camera, time, antialiased, rig, still = 1, clear = 0, widest = LARGEST }: Shot,
    origin: readonly [number, number] = [0, 0],
    paint: "colour" | "depth" = "colour",
  ): void {
    if (this.#count === 0 || !this.#program) return;
    const { gl } = this;
    const u = this.#program.uniforms;
    gl.viewport(...origin, camera.width, camera.height);
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
    gl.disable(gl.DITHER);
    gl.enable(gl.BLEND);
    gl.blendEquation(gl.FUNC_ADD);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA); // colours are multiplied by alpha in the shader
    gl.useProgram(this.#program.handle);
    gl.bindVertexArray(this.#vertices);
    this.#statics.bind(gl, 0);
    this.#dynamics.bind(gl, 1);
    this.#order.bind(gl, 2);
    this.#fifth.bind(gl, 3);
    gl.uniform1i(u.statics, 0);
    gl.uniform1i(u.dynamics, 1);
    gl.uniform1i(u.order, 2);
    gl.uniform1i(u.fifth, 3);
    gl.uniform1ui(u.count, this.#count);
    gl.uniformMatrix3fv(u.rotation, true, [...pose.rotation]); // row-major
    gl.uniform3f(u.translation, ...pose.translation);
    gl.uniform2f(u.focal, camera.fx, camera.fy);
    gl.uniform2f(u.centre, camera.cx, camera.cy);
    gl.uniform2f(u.size, camera.width, camera.height);
    gl.uniform2f(u.origin, ...origin);
    gl.uniform1f(u.time, time);
    gl.uniform1f(u.near, camera.near);
    gl.uniform1i(u.antialiased, antialiased ? 1 : 0);
    gl.uniform4f(u.magnification, ...magnification(rig, pose, camera));
    gl.uniform1f(u.still, still);
    gl.uniform2f(u.closeUp, clear, widest);
    gl.uniform1i(u.depths, paint === "depth" ? 1 : 0);
    this.surroundings?.prepare(gl);
    const instances = Math.ceil(this.#count / TRIANGLES_PER_INSTANCE);
    gl.drawArraysInstanced(gl.TRIANGLES, 0, 3 * TRIANGLES_PER_INSTANCE, instances);
    gl.bindVertexArray(null);
  }

  /** Delete everything created in the context; the context itself stays. */
  dispose(): void {
    const { gl } = this;
    this.#program?.dispose();
    gl.deleteVertexArray(this.#vertices);
    for (const texture of [this.#statics, this.#dynamics, this.#fifth, this.#order]) texture.dispose(gl);
    this.#count = 0;
  }
}
