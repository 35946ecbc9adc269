/**
 * The sound that comes with a scene's stream: the server sends it once it has been asked for, in its own order. What the stream
 * cannot bring is to be fetched by its id.
 */

import type { Manifest } from "../codec/types";

type Bytes = Uint8Array<ArrayBuffer>;

/** Milliseconds without a question after which the server is told to send no more: it is muted, or all has been asked for. */
const QUIET = 10_000;
/** Milliseconds after which a piece is fetched in another way. */
const PATIENCE = 4000;
/** Pieces that have come and were not asked for yet; of more, the first to come are let go. */
const KEPT = 64;

export class StreamedSound {
  readonly #here = new Map<string, Bytes>();
  readonly #awaited = new Map<string, (bytes: Bytes | null) => void>();
  readonly #sent = new Set<string>(); // which the server sends no more
  #wanted = false;
  #ended = false;
  #deaf = false; // a server that has been asked and sends none: an older one
  #quiet: ReturnType<typeof setTimeout> | undefined;

  /** @param changed is called when the server should be told anew whether sound is wanted. */
  constructor(
    readonly ids: Set<string>,
    readonly changed: () => void,
  ) {}

  /** Whether the server should send sound. */
  get wanted(): boolean {
    return this.#wanted;
  }

  /** Ids of what has come. */
  get sent(): readonly string[] {
    return [...this.#sent];
  }

  /** A piece when it comes; null if it does not come with the stream. */
  ask(id: string): Promise<Bytes | null> {
    const bytes = this.#here.get(id);
    this.#here.delete(id);
    if (this.ids.has(id)) this.#listen();
    if (bytes) return Promise.resolve(bytes);
    if (!this.ids.has(id) || this.#sent.has(id) || this.#ended || this.#deaf) return Promise.resolve(null);
    return new Promise((resolve) => {
      this.#settle(id, null);
      this.#awaited.set(id, resolve);
      setTimeout(() => {
        if (this.#awaited.get(id) !== resolve) return;
        this.#deaf ||= this.#sent.size === 0;
        this.#settle(id, null);
      }, PATIENCE);
    });
  }

  /** A piece has come. */
  arrived(id: string, bytes: Bytes): void {
    this.#sent.add(id);
    if (this.#settle(id, bytes)) return;
    this.#here.set(id, bytes);
    for (const first of this.#here.keys()) if (this.#here.size > KEPT) this.#here.delete(first);
  }

  /** The server cannot give a piece. */
  missing(id: string): void {
    this.#sent.add(id);
    this.#settle(id, null);
  }

  /** Nothing comes any more. */
  end(): void {
    this.#ended = true;
    clearTimeout(this.#quiet);
    for (const id of this.#awaited.keys()) this.#settle(id, null);
  }

  #listen(): void {
    clearTimeout(this.#quiet);
    if (this.#ended) return;
    this.#quiet = setTimeout(() => this.#want(false), QUIET);
    this.#want(true);
  }

  #want(wanted: boolean): void {
    if (this.#wanted === wanted) return;
    this.#wanted = wanted;
    this.changed();
  }

  #settle(id: string, bytes: Bytes | null): boolean {
    const resolve = this.#awaited.get(id);
    this.#awaited.delete(id);
    resolve?.(bytes);
    return resolve !== undefined;
  }
}

/** Ids of a scene's pieces of sound, as far as its manifest is here. */
export function soundsOf({ audio }: Manifest): Set<string> {
  const { pieces = [] } = (audio ?? {}) as { pieces?: { id: string }[] };
  return new Set(pieces.map(({ id }) => id));
}
