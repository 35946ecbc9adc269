/** Notices when a connection has died without a word, as happens when a network changes or a router forgets it. */

const QUIET = 4000; // ms without a message, after which the server is asked whether it is there
const ANSWER = 4000; // ms that its answer may take
const TICK = 500; // ms

export class LineWatch {
  readonly #timer = setInterval(() => this.#look(), TICK);
  #heard = performance.now();
  #looked = performance.now();
  #asked: number | null = null; // when; null while there is no question

  /**
   * @param ask sends a ping, if the connection is open yet.
   * @param dead is called once, when nothing has come.
   * @param patience times the waits are as long.
   */
  constructor(
    readonly ask: () => void,
    readonly dead: () => void,
    readonly patience: number,
  ) {}

  /** A message has come. */
  heard(): void {
    this.#heard = performance.now();
    this.#asked = null;
  }

  /** Ask now. */
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
    // After a sleep messages may have come that have not been dealt with: the time before it does not count.
    if (now - this.#looked > 4 * TICK) this.#asked = null;
    this.#looked = now;
    if (this.#asked !== null && now - this.#asked >= ANSWER * this.patience) {
      this.stop();
      this.dead();
    } else if (now - this.#heard >= QUIET * this.patience) {
      this.check();
    }
  }
}
