/**
 * When the device is done with a picture, from a fence behind it. Without it a slow device would be sent pictures faster
 * than it draws, and everything it shows would come late.
 */

export class GpuPace {
  readonly #gl: WebGL2RenderingContext;
  #fence: WebGLSync | null = null;
  #since = 0;
  #rung = 0;

  /** @param measured called with how long each picture took, milliseconds, and the rung that it was submitted with */
  constructor(
    gl: WebGL2RenderingContext,
    readonly measured: (duration: number, rung: number) => void,
  ) {
    this.#gl = gl;
  }

  /** Note that a picture has just been submitted. `now` in milliseconds, of any steady clock. */
  submitted(now: number, rung: number): void {
    if (this.#fence) this.#gl.deleteSync(this.#fence);
    this.#fence = this.#gl.fenceSync(this.#gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.#gl.flush();
    this.#since = now;
    this.#rung = rung;
  }

  /** Whether the last picture is still being drawn. */
  busy(now: number): boolean {
    if (!this.#fence) return false;
    const state = this.#gl.clientWaitSync(this.#fence, 0, 0);
    if (state === this.#gl.TIMEOUT_EXPIRED) return true;
    this.#gl.deleteSync(this.#fence);
    this.#fence = null;
    this.measured(now - this.#since, this.#rung);
    return false;
  }
}
