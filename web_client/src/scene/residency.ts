/**
 * Which of the chunks that move are in memory: those that the playhead needs first, as many as the textures hold. What it
 * has passed makes room, and is fetched again when its turn comes. Chunks that come too early wait as they came.
 */

import { chunksOf, sliceAt } from "../codec/manifest_chunks";
import type { ChunkEntry, Manifest } from "../codec/types";
import { rowsOf } from "../renderer/layout";
import type { ChunkState, ChunkStates } from "./chunk_states";

/** Chunks fetched again at once. */
const PARALLEL = 4;
/** Pause after a chunk could not be fetched, milliseconds. */
const PAUSE = 2000;
/** What waits may be so much, bytes, while the source still owes what is needed sooner: else the source would wait for us. */
const MOST_WAITING = 8 << 20;

export interface ResidencyEvents {
  /** Decode a chunk into these rows; answered by `decoded`, or by `lost`. */
  decode(id: string, bytes: Uint8Array<ArrayBuffer>, rows: readonly number[]): void;
  /** The chunk's rows are given to others. */
  evicted(id: string): void;
  /** A chunk that waited was let go of undecoded. */
  dropped(id: string): void;
  /** `update` has something to do. */
  changed(): void;
}

export class Residency {
  readonly #pool: RowPool;
  readonly #chunks = new Map<string, ChunkEntry>();
  readonly #abort = new AbortController();
  #ranking: string[] = []; // all chunks, those first that the playhead needs first
  #slice = -1; // of the ranking; -1 while there is none
  #stale = true;

  /**
   * @param rows of the texture.
   * @param fetchAgain brings a chunk that was received before.
   */
  constructor(
    readonly manifest: Manifest,
    readonly states: ChunkStates,
    rows: number,
    readonly events: ResidencyEvents,
    readonly fetchAgain: (id: string, signal: AbortSignal) => Promise<Uint8Array<ArrayBuffer>>,
  ) {
    this.#pool = new RowPool(rows);
    this.grow();
  }

  /** The manifest names all that it will, or has become a later version. */
  grow(): void {
    for (const { chunks } of this.manifest.slices) for (const chunk of chunks) this.#chunks.set(chunk.id, chunk);
    this.#slice = -1;
  }

  /** Whether the chunk is of those that come and go. */
  concerns(id: string): boolean {
    return this.#chunks.has(id);
  }

  /** A chunk has come. */
  offer(id: string, bytes: Uint8Array<ArrayBuffer>): void {
    const state = this.states.get(id);
    // A damaged chunk arrives once more, and its rows are still its own.
    if (state?.at === "decoding") this.events.decode(id, bytes, state.rows);
    else if (state?.at !== "drawn") this.#set(id, { at: "waiting", bytes });
  }

  /** A chunk has been decoded; also a static one. */
  decoded(id: string): void {
    const state = this.states.get(id);
    if (!state || state.at === "decoding") this.#set(id, { at: "drawn", rows: state?.rows ?? [] });
  }

  /** A chunk cannot be decoded, for good. */
  lost(id: string): void {
    const state = this.states.get(id);
    if (state?.at !== "decoding") return;
    this.#pool.give(state.rows);
    this.states.set(id, { at: "damaged" });
    this.#stale = true;
  }

  /** Make the best of the memory for a playhead at `time`, seconds; what orders show by `shown` stays where it is. */
  update(time: number, shown: () => ReadonlySet<string>): void {
    const slice = sliceAt(this.manifest.slices, time);
    if (slice !== this.#slice) this.#rank(slice);
    else if (!this.#stale) return;
    this.#stale = false;
    const wanted = this.#wanted();
    let fetching = [...this.states.values()].filter(({ at }) => at === "fetching").length;
    for (const id of wanted) {
      const state = this.states.get(id);
      if (state?.at === "waiting" && !this.#admit(id, state.bytes, wanted, shown)) break;
      if (state?.at === "evicted" && fetching < PARALLEL) {
        fetching++;
        void this.#fetch(id);
      }
    }
    if ([...wanted].some((id) => this.#owed(id))) this.#dropWaiting(wanted);
  }

  /** Fetch and report nothing any more. */
  dispose(): void {
    this.#abort.abort();
  }

  /** All chunks from a slice on, around the loop. */
  #rank(slice: number): void {
    const { slices } = this.manifest;
    const ids = slices.flatMap((_, i) => chunksOf(slices[(slice + i) % slices.length]));
    this.#ranking = [...new Set(ids)];
    this.#slice = slice;
  }

  /** The first of the ranking that fit into the texture together. */
  #wanted(): Set<string> {
    const wanted = new Set<string>();
    let rows = 0;
    for (const id of this.#ranking) {
      rows += this.#rowsOf(id);
      if (rows > this.#pool.rows) break;
      wanted.add(id);
    }
    return wanted;
  }

  /** Returns false if there is no room yet. */
  #admit(id: string, bytes: Uint8Array<ArrayBuffer>, wanted: Set<string>, shown: () => ReadonlySet<string>): boolean {
    const count = this.#rowsOf(id);
    const stays = this.#pool.free < count ? shown() : null;
    for (let i = this.#ranking.length - 1; this.#pool.free < count && i >= 0; i--) {
      const victim = this.#ranking[i];
      const state = this.states.get(victim);
      if (state?.at !== "drawn" || wanted.has(victim) || stays?.has(victim)) continue;
      this.#pool.give(state.rows);
      this.states.set(victim, { at: "evicted" });
      this.events.evicted(victim);
    }
    if (this.#pool.free < count) {
      this.#stale = true; // what is shown now will not be for long
      return false;
    }
    const rows = this.#pool.take(count);
    this.states.set(id, { at: "decoding", rows });
    this.events.decode(id, bytes, rows);
    return true;
  }

  async #fetch(id: string): Promise<void> {
    const { signal } = this.#abort;
    this.states.set(id, { at: "fetching" });
    try {
      const bytes = await this.fetchAgain(id, signal);
      if (!signal.aborted) this.offer(id, bytes);
    } catch {
      await new Promise((resolve) => setTimeout(resolve, PAUSE));
      if (!signal.aborted) this.#set(id, { at: "evicted" });
    }
  }

  /** The farthest that wait, while they are too much. */
  #dropWaiting(wanted: Set<string>): void {
    let sum = 0;
    for (const id of this.#ranking) {
      const state = this.states.get(id);
      if (state?.at !== "waiting") continue;
      sum += state.bytes.length;
      if (sum <= MOST_WAITING || wanted.has(id)) continue;
      this.states.set(id, { at: "evicted" });
      this.events.dropped(id);
    }
  }

  /** Whether only the source can bring the chunk: it never has, or damaged. */
  #owed(id: string): boolean {
    const state = this.states.get(id);
    return !state || state.at === "damaged";
  }

  #set(id: string, state: ChunkState): void {
    this.states.set(id, state);
    this.#stale = true;
    this.events.changed();
  }

  #rowsOf(id: string): number {
    const chunk = this.#chunks.get(id);
    return chunk ? rowsOf(chunk) : 0;
  }
}

export class RowPool {
  readonly #free: number[];

  constructor(readonly rows: number) {
    this.#free = Array.from({ length: rows }, (_, i) => rows - 1 - i); // the lowest is taken first
  }

  get free(): number {
    return this.#free.length;
  }

  /** @throws RangeError if there are not so many. */
  take(count: number): number[] {
    if (count > this.#free.length)
      throw new RangeError(`${count} rows are asked for, and ${this.#free.length} are free`);
    return this.#free.splice(this.#free.length - count).reverse();
  }

  give(rows: readonly number[]): void {
    this.#free.push(...rows);
    this.#free.sort((a, b) => b - a);
  }
}
