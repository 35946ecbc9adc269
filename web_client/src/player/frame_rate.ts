/** How many frames are drawn, and how many should have been. */

const WINDOW = 1000; // ms

export class FrameRate {
  readonly #times: number[] = []; // of the frames of the last second, or of the last two
  #resting = false;
  #drawn = 0;
  #dropped = 0;

  /** Frames drawn so far. */
  get drawn(): number {
    return this.#drawn;
  }

  /** Frames that were due while the scene played and were not drawn. */
  get dropped(): number {
    return this.#dropped;
  }

  /** Note a frame drawn at `now`, milliseconds. */
  count(now: number): void {
    const times = this.#times;
    if (this.#resting && now - (times.at(-1) ?? now) > WINDOW) times.length = 0;
    this.#resting = false;
    this.#drawn++;
    times.push(now);
    while (times.length > 2 && times[0] < now - WINDOW) times.shift();
  }

  /** Note a frame that is due and not drawn. */
  drop(): void {
    this.#dropped++;
  }

  /** Note that no frame is due until the next one is counted. */
  rest(): void {
    this.#resting = true;
  }

  /** Frames per second at `now`; 0 after a second of rest. A frame that is late lowers the rate before it comes. */
  rate(now: number): number {
    const times = this.#times;
    const since = now - (times.at(-1) ?? now);
    if (times.length === 0 || (this.#resting && since > WINDOW)) return 0;
    const mean = ((times.length - 1) * 1000) / (times[times.length - 1] - times[0] || 1);
    if (since <= WINDOW) return mean;
    return times.length > 1 ? Math.min(mean, 1000 / since) : 1000 / since;
  }
}
