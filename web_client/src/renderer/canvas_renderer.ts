/** The renderer of a page's canvas: a WebGL2 context of its own, for any camera and time. */

import { resized } from "../camera/pinhole";
import { CanvasTarget } from "./canvas_target";
import { LADDER, QualityControl } from "./fineness";
import { GpuPace } from "./gpu_pace";
import type { Pixels, Shot } from "./shot";
import { SplatDrawer } from "./splat_drawer";

export class CanvasRenderer {
  /** The drawer, with the scene's splats. */
  readonly splats: SplatDrawer;
  readonly #gl: WebGL2RenderingContext;
  readonly #listeners = new AbortController();
  /** The chosen quality, and the device's measured speed. */
  readonly quality = new QualityControl();
  #target!: CanvasTarget;
  #pace!: GpuPace;
  /** sRGB behind the splats, in [0, 1]. */
  background: readonly [number, number, number] = [0, 0, 0];
  /** Draws behind splats of which some fade. */
  backdrop?: (shot: Shot) => void;
  #lost = false;
  /** The extension, obtained beforehand: a lost context returns nothing, not even this. */
  readonly #loss: WEBGL_lose_context | null;
  #given = false; // true after giveBack, false after any other loss
  #wanted = true;

  /**
   * Create the context.
   *
   * @param onContext called when the context is lost, and when it is restored: then a new order must be set and the
   *   picture drawn.
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
        event.preventDefault(); // required for a restoration
        this.#lost = true;
        onContext(true);
        setTimeout(() => this.#takeBack()); // later than the browser's own handling
      },
      { signal },
    );
    canvas.addEventListener(
      "webglcontextrestored",
      () => {
        this.#lost = this.#given = false;
        this.splats.rebuild();
        this.#build();
        onContext(false);
        if (!this.#wanted) this.giveBack();
      },
      { signal },
    );
    this.#loss = gl.getExtension("WEBGL_lose_context");
    this.splats = new SplatDrawer(gl);
    this.#build();
  }

  /** Whether there is no context, be it lost or given back. */
  get lost(): boolean {
    return this.#lost || this.#gl.isContextLost();
  }

  /** Whether the context was given back and not lost. */
  get given(): boolean {
    return this.#given;
  }

  /** Release the context, until `take`. Its contents are gone. */
  giveBack(): void {
    this.#wanted = false;
    this.#given ||= !this.lost && this.#loss !== null;
    if (!this.lost) this.#loss?.loseContext();
  }

  /** Request a context again. */
  take(): void {
    this.#wanted = true;
    this.#takeBack();
  }

  /** A copy of a picture, in the best quality. */
  copy(shot: Shot): HTMLCanvasElement {
    this.draw(shot, this.quality.resting);
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [this.canvas.width, this.canvas.height];
    copy.getContext("2d")?.drawImage(this.canvas, 0, 0);
    return copy;
  }

  /** Whether the last picture is still being drawn; the next one should wait. `now` in milliseconds. */
  busy(now: number): boolean {
    return !this.lost && this.#pace.busy(now);
  }

  /** Draw to the canvas, with a backing store of the camera's size, in the fineness of a rung of `LADDER`. */
  draw(shot: Shot, rung: number): void {
    if (this.lost) return;
    const { width, height } = shot.camera;
    const drawn = this.#target.begin(width, height, LADDER[rung]);
    const smaller = drawn.width < width || drawn.height < height;
    this.fill(smaller ? { ...shot, camera: resized(shot.camera, drawn.width, drawn.height) } : shot);
    this.#target.end();
    this.#pace.submitted(performance.now(), rung);
  }

  /**
   * Draw and read the canvas, in one task: the browser clears it afterwards. The fineness is a rung of `LADDER`, by
   * default the one of pictures at rest.
   */
  readPixels(shot: Shot, rung = this.quality.resting): Pixels {
    this.draw(shot, rung);
    const gl = this.#gl;
    const { width, height } = shot.camera;
    const data = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, data);
    return { width, height, data: flipped(data, width, height) };
  }

  /** Release everything. */
  dispose(): void {
    this.#listeners.abort();
    this.#loss?.loseContext();
  }

  #takeBack(): void {
    const gone = this.#listeners.signal.aborted;
    if (this.#wanted && this.#given && this.#lost && !gone) this.#loss?.restoreContext();
  }

  #build(): void {
    if (this.lost) return;
    this.#target = new CanvasTarget(this.#gl);
    this.#pace = new GpuPace(this.#gl, (duration, rung) => this.quality.measured(duration, rung));
  }

  /** Draw into the bound target, over the background. */
  fill(shot: Shot): void {
    const gl = this.#gl;
    gl.clearColor(...this.background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    this.backdrop?.(shot);
    this.splats.draw(shot);
  }
}

/** Rows in reverse order: WebGL reads from the bottom row. */
export function flipped<T extends Uint8Array | Float32Array>(data: T, width: number, height: number): T {
  const out = data.slice() as T;
  for (let y = 0; y < height; y++) {
    const from = (height - 1 - y) * width * 4;
    out.set(data.subarray(from, from + width * 4), y * width * 4);
  }
  return out;
}
