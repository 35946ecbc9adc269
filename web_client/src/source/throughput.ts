/** How fast the line brings bytes. */

const SAMPLE = 100; // ms, at least
/** A line that has brought nothing for so long, ms, was not asked for anything, or is broken. */
const IDLE = 2000;
/** Means that halve what was so long ago, ms: the lower one counts, so that falls are noticed soon and rises believed late. */
const HALVES = [500, 3000];

export class Throughput {
  readonly #means = HALVES.map((half) => ({ half, sum: 0, weight: 0 }));
  #since = Number.NEGATIVE_INFINITY; // ms
  #bytes = 0;

  /** Note bytes that arrived at `now`, milliseconds. */
  count(bytes: number, now: number): void {
    const passed = now - this.#since;
    this.#bytes += bytes;
    if (passed < SAMPLE) return;
    if (passed < IDLE) {
      for (const mean of this.#means) {
        const kept = 0.5 ** (passed / mean.half);
        mean.sum = kept * mean.sum + ((1 - kept) * this.#bytes) / passed;
        mean.weight = kept * mean.weight + 1 - kept;
      }
    }
    this.#since = now;
    this.#bytes = 0;
  }

  /** Bytes per second at `now`, milliseconds; 0 while that is not known, and when nothing has come for long. */
  rate(now: number): number {
    if (now - this.#since > IDLE) return 0;
    return Math.min(...this.#means.map(({ sum, weight }) => (weight > 0 ? (1000 * sum) / weight : 0)));
  }
}
