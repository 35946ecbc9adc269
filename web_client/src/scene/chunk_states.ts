/** The states of a scene's chunks, in one table for decoding, eviction, drawing and statistics. */

export type ChunkState =
  /** Received, and not decoded yet for want of room. */
  | { readonly at: "waiting"; readonly bytes: Uint8Array<ArrayBuffer> }
  /** `rows` of the texture are the chunk's; none for a static one, which has its place for good. */
  | { readonly at: "decoding" | "drawn"; readonly rows: readonly number[] }
  /** Received before, and not in memory now. Evicted chunks are fetched again; damaged ones may be sent again. */
  | { readonly at: "evicted" | "fetching" | "damaged" };

/** The state of each chunk that was received, the static ones from their decoding on; and the chunks that are lost. */
export class ChunkStates extends Map<string, ChunkState> {
  readonly #lost = new Set<string>();

  override set(id: string, state: ChunkState): this {
    if (state.at === "drawn") this.#lost.delete(id);
    return super.set(id, state);
  }

  /** Give up a chunk, unless it is drawn already: the rest of its moment is drawn without it. */
  lose(id: string): void {
    if (this.get(id)?.at !== "drawn") this.#lost.add(id);
  }

  /** Whether there is nothing to wait for: the chunk is drawn, or lost. */
  settled(id: string): boolean {
    return this.get(id)?.at === "drawn" || this.#lost.has(id);
  }

  /** Number of chunks that are lost. */
  get lost(): number {
    return this.#lost.size;
  }
}
