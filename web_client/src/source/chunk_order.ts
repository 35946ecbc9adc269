/** The order in which a playhead needs chunks (docs/stream.md, "Order"), for sources that request each chunk. */

import { chunksOf, type Layered, layersOf, sliceAt } from "../codec/manifest_chunks";
import type { ChunkEntry, Manifest } from "../codec/types";
import type { Playhead } from "./scene_source";

/** Seconds of playing ahead; within each stretch, base layers come before refinements. */
const NEAR = 8;
const SENT_AHEAD = [3, NEAR, Number.POSITIVE_INFINITY];
/** Seconds of playing ahead for which pages of the manifest come before their chunks. */
const PAGES_SENT_AHEAD = 12;
/** Bytes that are about in flight before a refinement: one that cannot arrive before its slice is over has to wait. */
const UNDER_WAY = 1 << 16;

export class ChunkOrder {
  /** Every chunk by its id. */
  readonly chunks: ReadonlyMap<string, Layered>;

  constructor(readonly manifest: Manifest) {
    this.chunks = layersOf(manifest);
  }

  /** The chunks that a picture at a time requires: the base layers of the statics and of the slice shown then. */
  picture(time: number): ChunkEntry[] {
    const { static: stills, slices } = this.manifest;
    const slice = slices[sliceAt(slices, time)];
    return inTurn(this.#of(stills.map(toId), true), slice ? this.#of(chunksOf(slice), true) : []);
  }

  /**
   * The missing chunks, in order of need.
   *
   * @param bytesPerSecond rate of the line; 0 if unknown.
   * @param here whether a chunk is there or given up.
   */
  *missing({ time: at, rate }: Playhead, bytesPerSecond: number, here: (id: string) => boolean): Generator<ChunkEntry> {
    const { static: stills, slices, start, end } = this.manifest;
    const time = at ?? start;
    const asked = new Set<string>();
    const take = (chunks: readonly ChunkEntry[]) =>
      chunks.filter(({ id }) => !here(id) && !asked.has(id) && asked.add(id));
    yield* take(this.picture(time));
    const first = Math.max(0, sliceAt(slices, time));
    const around = [...slices.slice(first), ...slices.slice(0, first)];
    const soonest = bytesPerSecond > 0 ? time + (rate * UNDER_WAY) / bytesPerSecond : time;
    const within = (ahead: number) =>
      around.filter(
        (slice, i) => slice.start + (first + i < slices.length ? 0 : end - start) <= time + ahead * (rate || 1),
      );
    yield* take(within(PAGES_SENT_AHEAD).flatMap(({ chunks }) => chunks.filter(({ splats }) => !splats)));
    for (const ahead of SENT_AHEAD) {
      const near = within(ahead);
      yield* take(near.flatMap((slice) => this.#of(chunksOf(slice), true)));
      if (ahead <= NEAR && near[0]?.end <= soonest) near.shift();
      const moving = take(near.flatMap((slice) => this.#of(chunksOf(slice), false)));
      if (ahead <= NEAR) moving.sort((a, b) => this.#layer(a.id) - this.#layer(b.id));
      yield* inTurn(take(this.#of(stills.map(toId), false)), moving);
    }
  }

  /** The chunks of the base, or the others. */
  #of(ids: readonly string[], base: boolean): ChunkEntry[] {
    return ids.flatMap((id) => ((this.#layer(id) === 0) === base ? (this.chunks.get(id)?.chunk ?? []) : []));
  }

  #layer(id: string): number {
    return this.chunks.get(id)?.layer ?? 0;
  }
}

const toId = ({ id }: ChunkEntry): string => id;

const inTurn = (some: readonly ChunkEntry[], others: readonly ChunkEntry[]): ChunkEntry[] => [
  ...some.flatMap((chunk, i) => [chunk, ...others.slice(i, i + 1)]),
  ...others.slice(some.length),
];
