/** Draws the splats of a scene with WebGL2, from any camera, at any time. */

import { type Intrinsics, type Pose, resized } from "../camera/pinhole";
import { CanvasTarget } from "./canvas_target";
import { GpuPace } from "./gpu_pace";
import { DYNAMICS_PER_ROW, FIFTH_WIDTH, QUADS_PER_INSTANCE, STATICS_PER_ROW } from "./layout";
import { OrderTexture } from "./order_texture";
import { canDraw, PictureTarget } from "./picture_target";
import { Program } from "./program";
import { FRAGMENT_SHADER, VERTEX_SHADER } from "./shaders";
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
  "time",
  "near",
  "antialiased",
] as const;

/** What one picture shows, and how. */
export interface Shot {
  readonly pose: Pose;
  readonly camera: Intrinsics;
  /** Normalised time of the segment whose dynamics the order names. */
  readonly time: number;
  /**
   * Fade splats thinner than the low-pass, which else show too wide and too strong from afar (docs/numerics.md,
   * "Antialiasing"). On a page the player decides; pictures for the eyes of a headset always set it, or thin splats
   * shimmer as the head moves. A scene that was trained without it looks fainter so.
   */
  readonly antialiased: boolean;
}

/** Rows from the top, RGBA; bytes from the canvas, floats (linear in the same units, 0 to 1) from the float target. */
export interface Pixels {
  readonly width: number;
  readonly height: number;
  readonly data: Uint8Array | Float32Array;
}

export class SplatRenderer {
  readonly #gl: WebGL2RenderingContext;
  readonly #statics = new SplatTexture("static");
  readonly #dynamics = new SplatTexture("dynamic");
  readonly #fifth = new SplatTexture("dynamic", FIFTH_WIDTH);
  readonly #order = new OrderTexture();
  readonly #listeners = new AbortController();
  #program!: Program<(typeof UNIFORMS)[number]>;
  #target!: CanvasTarget;
  #pace!: GpuPace;
  /** sRGB behind the splats, in [0, 1]. */
  background: readonly [number, number, number] = [0, 0, 0];
  #dynamicRows = 0;
  #count = 0;
  #lost = false;

  /**
   * @param onContext called when the context is lost, and when it is back: then a new order must be set and the picture
   *   drawn.
   * @throws Error if the browser has no WebGL2.
   */
  constructor(
    readonly canvas: HTMLCanvasElement,
    onContext: (lost: boolean) => void,
  ) {
    const gl = canvas.getContext("webgl2", {
      alpha: false,
      antialias: false,
      depth: false,
      stencil: false,
      powerPreference: "high-performance",
    });
    if (!gl) throw new Error("this browser offers no WebGL2; enable hardware acceleration or try another browser");
    this.#gl = gl;
    const { signal } = this.#listeners;
    canvas.addEventListener(
      "webglcontextlost",
      (event) => {
        event.preventDefault(); // else it never comes back
        this.#lost = true;
        onContext(true);
      },
      { signal },
    );
    canvas.addEventListener(
      "webglcontextrestored",
      () => {
        this.#lost = false;
        this.#build();
        onContext(false);
      },
      { signal },
    );
    this.#build();
  }

  /** Splats in the current order. */
  get count(): number {
    return this.#count;
  }

  get lost(): boolean {
    return this.#lost;
  }

  /** Make room for a scene; `staticRows` and `dynamicRows` are texture rows. */
  allocate(staticRows: number, dynamicRows: number): void {
    this.#statics.allocate(this.#gl, staticRows);
    this.#dynamics.allocate(this.#gl, dynamicRows);
    this.#fifth.allocate(this.#gl, 0);
    this.#dynamicRows = dynamicRows;
  }

  /** Upload packed static splats; `first` is the id of the first, at the start of a row. */
  writeStatics(first: number, texels: Float32Array): void {
    this.#statics.write(this.#gl, first / STATICS_PER_ROW, texels);
  }

  /** Upload packed dynamic splats; `first` is the id of the first, at the start of a row. `fifth` may be empty. */
  writeDynamics(first: number, texels: Float32Array, fifth: Float32Array): void {
    const row = first / DYNAMICS_PER_ROW;
    this.#dynamics.write(this.#gl, row, texels);
    if (fifth.length === 0) return;
    if (!this.#fifth.filled) this.#fifth.allocate(this.#gl, this.#dynamicRows);
    this.#fifth.write(this.#gl, row, fifth);
  }

  /** Set what is drawn: `count` ids, farthest first, in an array of whole texture rows. */
  setOrder(ids: Uint32Array, count: number): void {
    if (this.#lost) return;
    this.#order.write(this.#gl, ids, count);
    this.#count = count;
  }

  /** Whether the last picture is still being drawn; the next one should wait. `now` in milliseconds. */
  busy(now: number): boolean {
    return !this.#lost && this.#pace.busy(now);
  }

  /** Whether this device is too slow to draw motion finely. */
  get slow(): boolean {
    return this.#pace.slow;
  }

  /** Draw to the canvas, whose backing store takes the camera's size; `quick` in half the resolution. */
  draw(shot: Shot, quick = false): void {
    if (this.#lost) return;
    const { width, height } = this.#target.begin(shot.camera.width, shot.camera.height, quick);
    this.#submit(quick ? { ...shot, camera: resized(shot.camera, width, height) } : shot);
    this.#target.end();
    this.#pace.submitted(performance.now(), quick);
  }

  /** Draw and read the canvas, in one task: the browser clears it afterwards. */
  readPixels(shot: Shot): Pixels {
    this.draw(shot);
    const gl = this.#gl;
    const { width, height } = shot.camera;
    const data = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, data);
    return { width, height, data: flipped(data, width, height) };
  }

  /**
   * Draw into a 32-bit float picture (16-bit where the device cannot blend 32) and read it.
   *
   * @throws Error if the device draws to no float format.
   */
  readFloatPixels(shot: Shot): Pixels {
    const { width, height } = shot.camera;
    const format = canDraw(this.#gl, "RGBA32F") ? "RGBA32F" : "RGBA16F";
    if (!canDraw(this.#gl, format)) throw new Error("this device cannot draw into float textures");
    const target = new PictureTarget(this.#gl, width, height, format);
    try {
      this.#submit(shot);
      return { width, height, data: flipped(target.read(), width, height) };
    } finally {
      target.dispose();
    }
  }

  /** Give everything back to the browser. */
  dispose(): void {
    this.#listeners.abort();
    this.#gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  #build(): void {
    const gl = this.#gl;
    this.#program = new Program(gl, VERTEX_SHADER, FRAGMENT_SHADER, UNIFORMS);
    this.#target = new CanvasTarget(gl);
    this.#pace = new GpuPace(gl);
    const indices = new Uint16Array(6 * QUADS_PER_INSTANCE);
    for (let quad = 0; quad < QUADS_PER_INSTANCE; quad++) {
      indices.set(
        [0, 1, 2, 2, 1, 3].map((corner) => 4 * quad + corner),
        6 * quad,
      );
    }
    gl.bindVertexArray(gl.createVertexArray());
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
    gl.disable(gl.DITHER);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA); // colours are multiplied by alpha in the shader
    this.#order.forget();
    this.#count = 0;
    this.#statics.create(gl);
    this.#dynamics.create(gl);
    this.#fifth.create(gl);
  }

  #submit({ pose, camera, time, antialiased }: Shot): void {
    const gl = this.#gl;
    const u = this.#program.uniforms;
    gl.viewport(0, 0, camera.width, camera.height);
    gl.clearColor(...this.background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    if (this.#count === 0) return;
    gl.useProgram(this.#program.handle);
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
    gl.uniform1f(u.time, time);
    gl.uniform1f(u.near, camera.near);
    gl.uniform1i(u.antialiased, antialiased ? 1 : 0);
    const instances = Math.ceil(this.#count / QUADS_PER_INSTANCE);
    gl.drawElementsInstanced(gl.TRIANGLES, 6 * QUADS_PER_INSTANCE, gl.UNSIGNED_SHORT, 0, instances);
  }
}

/** WebGL reads from the bottom row; pictures begin at the top. */
function flipped<T extends Uint8Array | Float32Array>(data: T, width: number, height: number): T {
  const out = data.slice() as T;
  for (let y = 0; y < height; y++) {
    const from = (height - 1 - y) * width * 4;
    out.set(data.subarray(from, from + width * 4), y * width * 4);
  }
  return out;
}
