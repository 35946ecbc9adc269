/** How fast the line brings bytes. */

const WINDOW = 1000; // ms

export class LineRate {
  readonly #arrivals: { readonly time: number; readonly bytes: number }[] = [];
  #sum = 0; // of their bytes

  /** Note bytes that arrived at `now`, milliseconds. */
  count(bytes: number, now: number): void {
    this.#arrivals.push({ time: now, bytes });
    this.#sum += bytes;
    this.#forget(now);
  }

  /** Bytes per second, over the second before `now`. */
  rate(now: number): number {
    this.#forget(now);
    return (this.#sum * 1000) / WINDOW;
  }

  #forget(now: number): void {
    while (this.#arrivals.length > 0 && this.#arrivals[0].time < now - WINDOW) {
      this.#sum -= this.#arrivals.shift()?.bytes ?? 0;
    }
  }
}
