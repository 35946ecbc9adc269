/** How long it takes from asking for an order to the frame that shows it. */

const RECENT = 5;
/** Longest lead that is believed, milliseconds: a machine that has been asleep is no measure. */
const LONGEST = 250;

export class OrderLead {
  readonly #recent: number[] = [];

  /** Note that an order was shown so many milliseconds after it was asked for. */
  note(duration: number): void {
    this.#recent.push(Math.min(LONGEST, Math.max(0, duration)));
    if (this.#recent.length > RECENT) this.#recent.shift();
  }

  /** Milliseconds: the median of the last few, which one hiccup does not move; 0 before the first. */
  get duration(): number {
    const sorted = [...this.#recent].sort((a, b) => a - b);
    return sorted[sorted.length >> 1] ?? 0;
  }
}
