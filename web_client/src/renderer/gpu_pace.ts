/**
 * How fast the device draws, from fences behind its pictures. Without them a slow device would be sent pictures faster
 * than it draws, and everything it shows would come late.
 */

/** A fine picture that takes longer is too slow for motion, milliseconds. */
const SLOW = 60;
/** So many of them in a row, because the first ones wait for shaders and uploads. */
const PATIENCE = 4;

export class GpuPace {
  readonly #gl: WebGL2RenderingContext;
  #fence: WebGLSync | null = null;
  #since = 0;
  #quick = false;
  #slowPictures = 0;

  constructor(gl: WebGL2RenderingContext) {
    this.#gl = gl;
  }

  /** Note that a picture has just been submitted. `now` in milliseconds, of any steady clock. */
  submitted(now: number, quick: boolean): void {
    if (this.#fence) this.#gl.deleteSync(this.#fence);
    this.#fence = this.#gl.fenceSync(this.#gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.#gl.flush();
    this.#since = now;
    this.#quick = quick;
  }

  /** Whether the last picture is still being drawn. */
  busy(now: number): boolean {
    if (!this.#fence) return false;
    const state = this.#gl.clientWaitSync(this.#fence, 0, 0);
    if (state === this.#gl.TIMEOUT_EXPIRED) return true;
    this.#gl.deleteSync(this.#fence);
    this.#fence = null;
    this.#measured(now - this.#since);
    return false;
  }

  /** Whether fine pictures are too slow for motion. */
  get slow(): boolean {
    return this.#slowPictures >= PATIENCE;
  }

  /** Fine pictures alone are measured: when motion ends and one is fast, motion is drawn finely again. */
  #measured(duration: number): void {
    if (this.#quick) return;
    this.#slowPictures = duration > SLOW ? this.#slowPictures + 1 : 0;
  }
}
