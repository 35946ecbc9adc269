/**
 * How much the server may have in flight: twice what the line carries in a round trip, and no more, because a seek waits
 * behind it.
 */

const SMALLEST = 64 << 10; // bytes; the first window, too: a slow line is filled by it at any distance
const LARGEST = 2 << 20; // bytes; fills 50 Mbit/s at 300 ms
const SHORTEST_TRIP = 25; // ms; less is gained by a smaller window than is lost by its many grants
const SHORTEST_ROUND = 50; // ms over which the rate is measured: the browser hands over what has come in bursts
const ROUNDS = 8; // whose greatest rate counts: what is short of data or of time in between measures less

export class CreditWindow {
  #size = SMALLEST;
  #inFlight = 0; // granted bytes that have not come
  #trip: number;
  #round: { start: number; bytes: number } | null = null;
  #asked: number | null = null; // when the ping that is not answered was sent
  readonly #rates: number[] = []; // of the last rounds, bytes per ms

  /** @param trip at least as long as a round trip on the empty line, ms; `now` is always ms of one steady clock. */
  constructor(trip: number) {
    this.#trip = trip;
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
    this.#trip = Math.min(this.#trip, now - this.#asked);
    this.#asked = null;
  }

  /** The shortest trip is that of an empty line: under load pings wait behind the window, and would make it grow. */
  #measured(rate: number): void {
    this.#rates.push(rate);
    if (this.#rates.length > ROUNDS) this.#rates.shift();
    const wanted = 2 * Math.max(...this.#rates) * Math.max(this.#trip, SHORTEST_TRIP);
    this.#size = Math.min(LARGEST, Math.max(SMALLEST, Math.round(wanted)));
  }
}
