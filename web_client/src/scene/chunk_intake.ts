/** The way of chunks to their decoder: keeps the source's credit, and fetches again what arrives damaged. */

/** Pauses before a damaged chunk is fetched again, milliseconds: at once, and then when a disturbance may have passed. */
const PAUSES = [0, 1000];

export interface IntakeEvents {
  /** Decode a chunk; answered by `done` or `damaged`. */
  decode(id: string, bytes: Uint8Array<ArrayBuffer>): void;
  /** The decoder is done with so many bytes. */
  consumed(bytes: number): void;
  /** A chunk stays damaged; `message` says how. */
  lost(id: string, message: string): void;
}

export class ChunkIntake {
  readonly #streamed = new Map<string, number>(); // sizes of chunks at the decoder, bytes
  readonly #fetched = new Map<string, number>(); // how often a chunk has been fetched again
  readonly #abort = new AbortController();

  /** @param fetchAgain brings a chunk's bytes once more. */
  constructor(
    readonly events: IntakeEvents,
    readonly fetchAgain: (id: string, signal: AbortSignal) => Promise<Uint8Array<ArrayBuffer>>,
  ) {}

  /** A complete chunk has come from the source. */
  arrived(id: string, bytes: Uint8Array<ArrayBuffer>): void {
    this.#streamed.set(id, bytes.length);
    this.events.decode(id, bytes);
  }

  /** A chunk has been decoded, or let go of. */
  done(id: string): void {
    this.#consume(id);
  }

  /** A chunk cannot be decoded; `message` says why. */
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

  /** Fetch and report nothing any more. */
  dispose(): void {
    this.#abort.abort();
  }

  /** Only chunks that the source brought by itself cost credit. */
  #consume(id: string): void {
    const bytes = this.#streamed.get(id);
    if (bytes === undefined) return;
    this.#streamed.delete(id);
    this.events.consumed(bytes);
  }
}
