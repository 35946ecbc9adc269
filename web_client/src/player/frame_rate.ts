/** Frames drawn over the last second. */

const WINDOW = 1000; // ms

export class FrameRate {
  readonly #times: number[] = [];

  /** Note a frame drawn at `now`, milliseconds. */
  count(now: number): void {
    this.#times.push(now);
    while (this.#times[0] < now - WINDOW) this.#times.shift();
  }

  /** Frames per second; 0 before the second frame, and after a second without one. */
  get value(): number {
    const times = this.#times;
    if (times.length < 2 || performance.now() - times[times.length - 1] > WINDOW) return 0;
    return ((times.length - 1) * 1000) / (times[times.length - 1] - times[0]);
  }
}
