/**
 * The sound of a scene's stream: sent by the server on request, in the server's order. Pieces that the stream cannot
 * bring are fetched by their ids.
 */

import type { Manifest } from "../codec/types";

type Bytes = Uint8Array<ArrayBuffer>;

/** Milliseconds without a request before the server should stop sending: the player is muted, or has everything. */
const QUIET = 10_000;
/** Milliseconds of waiting for a piece before it is fetched in another way. */
const PATIENCE = 4000;
/** Received pieces kept until they are requested; the oldest are dropped first. */
const KEPT = 64;

export class StreamedSound {
  readonly #here = new Map<string, Bytes>();
  readonly #awaited = new Map<string, (bytes: Bytes | null) => void>();
  readonly #sent = new Set<string>(); // pieces that the server does not send again
  #wanted = false;
  #ended = false;
  #deaf = false; // an older server, which sends no sound
  #quiet: ReturnType<typeof setTimeout> | undefined;

  /**
   * Track the sound of a stream.
   *
   * @param changed is called when the server should be informed whether to send sound.
   */
  constructor(
    readonly ids: Set<string>,
    readonly changed: () => void,
  ) {}

  /** Whether the server should send sound. */
  get wanted(): boolean {
    return this.#wanted;
  }

  /** Ids of the received pieces. */
  get sent(): readonly string[] {
    return [...this.#sent];
  }

  /** A piece, when it arrives; null if the stream does not bring it. */
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

  /** A piece has arrived. */
  arrived(id: string, bytes: Bytes): void {
    this.#sent.add(id);
    if (this.#settle(id, bytes)) return;
    this.#here.set(id, bytes);
    for (const first of this.#here.keys()) if (this.#here.size > KEPT) this.#here.delete(first);
  }

  /** The server cannot send a piece. */
  missing(id: string): void {
    this.#sent.add(id);
    this.#settle(id, null);
  }

  /** The stream has ended. */
  end(): void {
    this.#ended = true;
    clearTimeout(this.#quiet);
    for (const id of this.#awaited.keys()) this.#settle(id, null);
  }

  #listen(): void {
    clearTimeout(this.#quiet);
    if (this.#ended) return;
    this.#quiet = setTimeout(() => this.#request(false), QUIET);
    this.#request(true);
  }

  #request(wanted: boolean): void {
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

/** Ids of a scene's pieces of sound in the manifest so far. */
export function soundsOf({ audio }: Manifest): Set<string> {
  const { pieces = [] } = (audio ?? {}) as { pieces?: { id: string }[] };
  return new Set(pieces.map(({ id }) => id));
}
