/** Detection of connections that died silently, for example when the network changed or a router dropped them. */

const QUIET = 4000; // ms without a message before a ping to the server
const ANSWER = 4000; // ms for its answer
const TICK = 500; // ms

export class LineWatch {
  readonly #timer = setInterval(() => this.#look(), TICK);
  #received = performance.now();
  #looked = performance.now();
  #asked: number | null = null; // send time of the ping; null without one

  /**
   * Watch a connection.
   *
   * @param ask sends a ping, if the connection is open yet.
   * @param dead is called once, when no answer has arrived.
   * @param patience factor of both waits.
   */
  constructor(
    readonly ask: () => void,
    readonly dead: () => void,
    readonly patience: number,
  ) {}

  /** A message has arrived. */
  received(): void {
    this.#received = performance.now();
    this.#asked = null;
  }

  /** Send a ping now. */
  check(): void {
    if (this.#asked !== null) return;
    this.#asked = performance.now();
    this.ask();
  }

  stop(): void {
    clearInterval(this.#timer);
  }

  #look(): void {
    const now = performance.now();
    // Messages may have arrived during a sleep of the machine and not been handled yet: that time does not count.
    if (now - this.#looked > 4 * TICK) this.#asked = null;
    this.#looked = now;
    if (this.#asked !== null && now - this.#asked >= ANSWER * this.patience) {
      this.stop();
      this.dead();
    } else if (now - this.#received >= QUIET * this.patience) {
      this.check();
    }
  }
}
