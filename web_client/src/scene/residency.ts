/**
 * The dynamic chunks in memory: as many as fit into the textures, in the order in which the playhead needs them. Passed
 * chunks make room, and are fetched again later. Chunks that arrive too early wait in compressed form.
 */

import { chunksOf, sliceAt } from "../codec/manifest_chunks";
import type { ChunkEntry, Manifest } from "../codec/types";
import { rowsOf } from "../renderer/layout";
import type { ChunkState, ChunkStates } from "./chunk_states";

/** Parallel fetches of evicted chunks. */
const PARALLEL = 4;
/** Pause after a failed fetch, milliseconds. */
const PAUSE = 2000;
/** Most bytes of waiting chunks while the source still owes more urgent ones: else the source would wait for us. */
const MOST_WAITING = 8 << 20;

export interface ResidencyEvents {
  /** Decode a chunk into these rows; answered by `decoded`, or by `lost`. */
  decode(id: string, bytes: Uint8Array<ArrayBuffer>, rows: readonly number[]): void;
  /** The chunk's rows are reused. */
  evicted(id: string): void;
  /** A waiting chunk was dropped undecoded. */
  dropped(id: string): void;
  /** The next `update` has work to do. */
  changed(): void;
}

export class Residency {
  readonly #pool: RowPool;
  readonly #chunks = new Map<string, ChunkEntry>();
  readonly #abort = new AbortController();
  #ranking: string[] = []; // all chunks, most urgent first
  #slice = -1; // slice of the ranking; -1 without one
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

  /** The manifest is complete, or has become a later version. */
  grow(): void {
    for (const { chunks } of this.manifest.slices) for (const chunk of chunks) this.#chunks.set(chunk.id, chunk);
    this.#slice = -1;
  }

  /** Whether a chunk is dynamic. */
  concerns(id: string): boolean {
    return this.#chunks.has(id);
  }

  /** A chunk has arrived. */
  offer(id: string, bytes: Uint8Array<ArrayBuffer>): void {
    const state = this.states.get(id);
    // A damaged chunk has arrived again, and still has its rows.
    if (state?.at === "decoding") this.events.decode(id, bytes, state.rows);
    else if (state?.at !== "drawn") this.#set(id, { at: "waiting", bytes });
  }

  /** A chunk has been decoded; also a static one. */
  decoded(id: string): void {
    const state = this.states.get(id);
    if (!state || state.at === "decoding") this.#set(id, { at: "drawn", rows: state?.rows ?? [] });
  }

  /** A chunk is damaged for good. */
  lost(id: string): void {
    const state = this.states.get(id);
    if (state?.at !== "decoding") return;
    this.#pool.give(state.rows);
    this.states.set(id, { at: "damaged" });
    this.#stale = true;
  }

  /** Use the memory best for a playhead at `time`, seconds; chunks of the displayed orders, `shown`, stay. */
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

  /** Stop fetching and reporting. */
  dispose(): void {
    this.#abort.abort();
  }

  /** Rank all chunks from a slice on, around the loop. */
  #rank(slice: number): void {
    const { slices } = this.manifest;
    const ids = slices.flatMap((_, i) => chunksOf(slices[(slice + i) % slices.length]));
    this.#ranking = [...new Set(ids)];
    this.#slice = slice;
  }

  /** The most urgent chunks that fit into the texture together. */
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

  /** Decode a chunk if there is room; returns false if there is none yet. */
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
      this.#stale = true; // retry when the displayed orders have changed
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

  /** Drop the least urgent waiting chunks beyond the limit. */
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

  /** Whether only the source can bring the chunk: it has not arrived, or only damaged. */
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

  /**
   * Take rows.
   *
   * @throws RangeError if fewer are free.
   */
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
