/** The rate at which the line brings bytes. */

const SAMPLE = 100; // ms, the shortest sample
/** Longest pause of a line in use, ms: one that is quiet for longer had no requests, or is broken. */
const IDLE = 2000;
/** Half-lives of running means, ms: the lowest mean counts, so that falls show soon and rises late. */
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

  /** Bytes per second at `now`, milliseconds; 0 while unknown, and after a long silence. */
  rate(now: number): number {
    if (now - this.#since > IDLE) return 0;
    return Math.min(...this.#means.map(({ sum, weight }) => (weight > 0 ? (1000 * sum) / weight : 0)));
  }
}
