/** Reports of the line's rate to the server, which then skips chunks that would arrive too late. */

import { Throughput } from "./throughput";

/** Shortest pause between reports, ms, and smallest change. */
const PAUSE = 1000;
const CHANGE = 1.2;

export class RateReports {
  readonly #line = new Throughput();
  #at = Number.NEGATIVE_INFINITY; // ms
  #rate = 0;

  /**
   * Measure the line.
   *
   * @param report is called when `rate` should be reported to the server.
   */
  constructor(readonly report: () => void) {}

  /** The rate to report, bytes per second; 0 while unknown. */
  get rate(): number {
    return this.#rate;
  }

  /** Note bytes that arrived at `now`, milliseconds. */
  count(bytes: number, now: number): void {
    this.#line.count(bytes, now);
    const rate = Math.round(this.#line.rate(now));
    const change = rate / this.#rate; // infinite at first
    if (rate === 0 || now - this.#at < PAUSE || (change < CHANGE && change > 1 / CHANGE)) return;
    this.#at = now;
    this.#rate = rate;
    this.report();
  }

  /** Forget the reported rate, for a new connection. */
  forget(): void {
    this.#rate = 0;
  }
}
