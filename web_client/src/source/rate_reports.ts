/** When to tell a server how fast the line is: what would come too late can then be left for later. */

import { Throughput } from "./throughput";

/** It is told so often at most, ms, and when it has changed by so much. */
const TELL = 1000;
const CHANGE = 1.2;

export class RateReports {
  readonly #line = new Throughput();
  #at = Number.NEGATIVE_INFINITY; // ms
  #rate = 0;

  /** @param tell is called when the server should be told `rate`. */
  constructor(readonly tell: () => void) {}

  /** What is to be told, bytes per second; 0 while that is not known. */
  get rate(): number {
    return this.#rate;
  }

  /** Note bytes that arrived at `now`, milliseconds. */
  count(bytes: number, now: number): void {
    this.#line.count(bytes, now);
    const rate = Math.round(this.#line.rate(now));
    const change = rate / this.#rate; // infinite at first
    if (rate === 0 || now - this.#at < TELL || (change < CHANGE && change > 1 / CHANGE)) return;
    this.#at = now;
    this.#rate = rate;
    this.tell();
  }

  /** Another connection, another server: what was told counts no more. */
  forget(): void {
    this.#rate = 0;
  }
}
