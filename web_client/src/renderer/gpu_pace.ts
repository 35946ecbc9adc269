/**
 * The completion of pictures on the device, from a fence behind each. Without it a slow device would receive pictures
 * faster than it draws, and show all of them late.
 */

export class GpuPace {
  readonly #gl: WebGL2RenderingContext;
  #fence: WebGLSync | null = null;
  #since = 0;
  #rung = 0;

  /**
   * Watch a device.
   *
   * @param measured called with each picture's duration, milliseconds, and its rung
   */
  constructor(
    gl: WebGL2RenderingContext,
    readonly measured: (duration: number, rung: number) => void,
  ) {
    this.#gl = gl;
  }

  /** Note the submission of a picture at `now`, milliseconds of any steady clock. */
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
