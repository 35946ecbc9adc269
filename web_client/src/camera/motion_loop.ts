/** A motion over many animation frames, until it ends or another begins. */

/** Longest step, seconds: a page that was hidden does not jump. */
const LONGEST_STEP = 0.1;

export class MotionLoop {
  #frame = 0; // 0 at rest

  constructor(signal: AbortSignal) {
    signal.addEventListener("abort", () => this.stop());
  }

  get running(): boolean {
    return this.#frame !== 0;
  }

  /** Call `step` at every frame with the seconds since the last one, until it returns false. */
  run(step: (seconds: number) => boolean): void {
    this.stop();
    let last = performance.now();
    const next = (now: number): void => {
      const seconds = Math.max(0, Math.min(LONGEST_STEP, (now - last) / 1000));
      last = now;
      this.#frame = step(seconds) ? requestAnimationFrame(next) : 0;
    };
    this.#frame = requestAnimationFrame(next);
  }

  stop(): void {
    cancelAnimationFrame(this.#frame);
    this.#frame = 0;
  }
}
