/** The intake of chunks for the decoder: returns the source's credit, and fetches damaged chunks again. */

/** Pauses before a damaged chunk is fetched again, milliseconds: at once, and then after a possible disturbance. */
const PAUSES = [0, 1000];

export interface IntakeEvents {
  /** Decode a chunk; answered by `done` or `damaged`. */
  decode(id: string, bytes: Uint8Array<ArrayBuffer>): void;
  /** The decoder has finished a number of bytes. */
  consumed(bytes: number): void;
  /** A chunk stays damaged; `message` is the reason. */
  lost(id: string, message: string): void;
}

export class ChunkIntake {
  readonly #streamed = new Map<string, number>(); // sizes of chunks at the decoder, bytes
  readonly #fetched = new Map<string, number>(); // times that a chunk has been fetched again
  readonly #abort = new AbortController();

  /**
   * Take chunks in.
   *
   * @param fetchAgain brings a chunk's bytes once more.
   */
  constructor(
    readonly events: IntakeEvents,
    readonly fetchAgain: (id: string, signal: AbortSignal) => Promise<Uint8Array<ArrayBuffer>>,
  ) {}

  /** A complete chunk has arrived from the source. */
  arrived(id: string, bytes: Uint8Array<ArrayBuffer>): void {
    this.#streamed.set(id, bytes.length);
    this.events.decode(id, bytes);
  }

  /** A chunk has been decoded, or dropped. */
  done(id: string): void {
    this.#consume(id);
  }

  /** A chunk cannot be decoded; `message` is the reason. */
  async damaged(id: string, message: string): Promise<void> {
    this.#consume(id);
    const times = this.#fetched.get(id) ?? 0;
    if (times >= PAUSES.length) {
      this.events.lost(id, message);
      return;
    }
    this.#fetched.set(id, times + 1);
    const { signal } = this.#abort;
    await new Promise((resolve) => setTimeout(resolve, PAUSES[times]));
    if (signal.aborted) return;
    try {
      const bytes = await this.fetchAgain(id, signal);
      if (!signal.aborted) this.events.decode(id, bytes);
    } catch (error) {
      if (signal.aborted) return;
      const reason = error instanceof Error ? error.message : String(error);
      await this.damaged(id, `${message} (fetching it again: ${reason})`);
    }
  }

  /** Stop fetching and reporting. */
  dispose(): void {
    this.#abort.abort();
  }

  /** Return a chunk's credit; only chunks of the stream cost any. */
  #consume(id: string): void {
    const bytes = this.#streamed.get(id);
    if (bytes === undefined) return;
    this.#streamed.delete(id);
    this.events.consumed(bytes);
  }
}
