/**
 * The limit of bytes in flight: twice the content of the line in a round trip, and no more, because a seek waits behind
 * it.
 */

const SMALLEST = 64 << 10; // bytes; the first window, too: it fills a slow line at any distance
const LARGEST = 2 << 20; // bytes; fills 50 Mbit/s at 300 ms
const SHORTEST_TRIP = 50; // ms; 0.1 s in flight bridges interruptions of page or radio, and hardly delays a seek
const SHORTEST_ROUND = 2 * SHORTEST_TRIP; // ms of a measurement of the rate: a burst must not raise it
const GROWTH = 1.25; // factor of the rate between rounds while there is room for more
const ROUNDS = 8; // number of recent rounds for the greatest rate: rounds short of data or time measure less

export class CreditWindow {
  #size = SMALLEST;
  /** Further rounds without a higher rate before the line counts as full; 0 when it does. */
  #chances = 2;
  #inFlight = 0; // granted bytes that have not arrived
  #trip: number;
  #round: { start: number; bytes: number } | null = null;
  #asked: number | null; // send time of the unanswered ping
  readonly #rates: number[] = []; // rates of recent rounds, bytes per ms

  /**
   * Start with the first grant and a ping before its data, while the line is empty.
   *
   * @param trip upper bound of a round trip on the empty line, ms.
   * @param now here and below, ms of one steady clock.
   */
  constructor(trip: number, now: number) {
    this.#trip = trip;
    this.#asked = now;
  }

  /** Bytes. */
  get size(): number {
    return this.#size;
  }

  /** Bytes to grant now; 0 while that is not worth a message. */
  grant(): number {
    const room = this.#size - this.#inFlight;
    if (room < this.#size / 4) return 0;
    this.#inFlight += room;
    return room;
  }

  /** Count a chunk frame. Returns true if a ping is needed, to measure the round trip that begins with it. */
  received(bytes: number, now: number): boolean {
    this.#inFlight -= bytes;
    if (this.#chances > 0) this.#size = Math.min(LARGEST, this.#size + bytes); // doubles with every trip
    if (this.#round) this.#round.bytes += bytes;
    if (this.#asked !== null || (this.#round && now - this.#round.start < SHORTEST_ROUND)) return false;
    if (this.#round) this.#measured(this.#round.bytes / (now - this.#round.start));
    this.#round = { start: now, bytes: 0 };
    this.#asked = now;
    return true;
  }

  /** The answer to the ping has arrived. */
  answered(now: number): void {
    if (this.#asked === null) return;
    const trip = now - this.#asked;
    this.#asked = null;
    this.#trip = Math.min(this.#trip, trip);
    if (trip > 2 * Math.max(this.#trip, SHORTEST_TRIP)) this.#chances = 0;
  }

  /**
   * Adjust the window to a measured rate. The shortest trip is that of an empty line: under load, pings wait behind the
   * window, and would make it grow.
   */
  #measured(rate: number): void {
    if (rate < GROWTH * Math.max(0, ...this.#rates)) this.#chances--;
    this.#rates.push(rate);
    if (this.#rates.length > ROUNDS) this.#rates.shift();
    const wanted = 2 * Math.max(...this.#rates) * Math.max(this.#trip, SHORTEST_TRIP);
    const least = this.#chances > 0 ? this.#size : SMALLEST;
    this.#size = Math.min(LARGEST, Math.max(least, Math.round(wanted)));
  }
}
