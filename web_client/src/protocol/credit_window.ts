/**
 * How much the server may have in flight: twice what the line carries in a round trip, and no more, because a seek waits
 * behind it.
 */

const SMALLEST = 64 << 10; // bytes; the first window, too: a slow line is filled by it at any distance
const LARGEST = 2 << 20; // bytes; fills 50 Mbit/s at 300 ms
const SHORTEST_TRIP = 50; // ms; a tenth of a second in flight bridges what holds up the page or the air, and harms no seek
const SHORTEST_ROUND = 2 * SHORTEST_TRIP; // ms over which the rate is measured: a burst must not make it greater
const GROWTH = 1.25; // of the rate from round to round while there is room for more
const ROUNDS = 8; // whose greatest rate counts: what is short of data or of time in between measures less

export class CreditWindow {
  #size = SMALLEST;
  /** Rounds that may yet bring no more than those before; 0 when the line is full. */
  #chances = 2;
  #inFlight = 0; // granted bytes that have not come
  #trip: number;
  #round: { start: number; bytes: number } | null = null;
  #asked: number | null; // when the ping that is not answered was sent
  readonly #rates: number[] = []; // of the last rounds, bytes per ms

  /**
   * A ping is sent with the first grant, while the line is empty: before what it is granted for.
   *
   * @param trip at least as long as a round trip on the empty line, ms.
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

  /** What to grant now, bytes; 0 while it is not worth a message. */
  grant(): number {
    const room = this.#size - this.#inFlight;
    if (room < this.#size / 4) return 0;
    this.#inFlight += room;
    return room;
  }

  /** A chunk frame has come. Returns true if a ping is to be sent, to measure the round trip that begins with it. */
  received(bytes: number, now: number): boolean {
    this.#inFlight -= bytes;
    if (this.#chances > 0) this.#size = Math.min(LARGEST, this.#size + bytes); // doubles it with every trip
    if (this.#round) this.#round.bytes += bytes;
    if (this.#asked !== null || (this.#round && now - this.#round.start < SHORTEST_ROUND)) return false;
    if (this.#round) this.#measured(this.#round.bytes / (now - this.#round.start));
    this.#round = { start: now, bytes: 0 };
    this.#asked = now;
    return true;
  }

  /** The ping has been answered. */
  answered(now: number): void {
    if (this.#asked === null) return;
    const trip = now - this.#asked;
    this.#asked = null;
    this.#trip = Math.min(this.#trip, trip);
    if (trip > 2 * Math.max(this.#trip, SHORTEST_TRIP)) this.#chances = 0;
  }

  /** The shortest trip is that of an empty line: under load pings wait behind the window, and would make it grow. */
  #measured(rate: number): void {
    if (rate < GROWTH * Math.max(0, ...this.#rates)) this.#chances--;
    this.#rates.push(rate);
    if (this.#rates.length > ROUNDS) this.#rates.shift();
    const wanted = 2 * Math.max(...this.#rates) * Math.max(this.#trip, SHORTEST_TRIP);
    const least = this.#chances > 0 ? this.#size : SMALLEST;
    this.#size = Math.min(LARGEST, Math.max(least, Math.round(wanted)));
  }
}
