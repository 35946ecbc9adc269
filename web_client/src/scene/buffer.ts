/** The buffer: received chunks, and the moments that can be shown with them. */

import { chunksOf, type Layered, layersOf, sliceAt } from "../codec/manifest_chunks";
import type { Manifest } from "../codec/types";
import { ChunkStates } from "./chunk_states";

/** Longest forecast of the line's rate, seconds. */
const FORESEEN = 10;

export class SceneBuffer {
  readonly states = new ChunkStates();
  #layers: ReadonlyMap<string, Layered>; // layers of all chunks

  constructor(readonly manifest: Manifest) {
    this.#layers = layersOf(manifest);
  }

  /** The manifest has become a later version. */
  grow(): void {
    this.#layers = layersOf(this.manifest);
  }

  /** True if every dynamic splat alive at `time` is drawn, or lost. */
  ready(time: number): boolean {
    return this.#here(this.#shownAt(time), true);
  }

  /** True if the base layers of all chunks shown at `time` are drawn or lost: other layers only refine the picture. */
  playable(time: number): boolean {
    return this.#here([...this.#statics, ...this.#shownAt(time)], false);
  }

  /**
   * Whether playing from `time` on, at `rate`, is likely not to stall within `reserve` seconds, given the rate of the
   * line.
   */
  lasts(time: number, rate: number, bytesPerSecond: number, reserve: number): boolean {
    const { slices } = this.manifest;
    const lacking = new Set<string>();
    let bytes = 0;
    for (const slice of slices.slice(Math.max(0, sliceAt(slices, time)))) {
      const wait = (slice.start - time) / rate;
      if (wait > FORESEEN) break;
      for (const id of chunksOf(slice)) {
        if (!lacking.has(id) && !this.#here([id], false)) bytes += this.#layers.get(id)?.chunk.bytes ?? 0;
        lacking.add(id);
      }
      if (bytes > bytesPerSecond * Math.max(0, wait)) return wait >= reserve;
    }
    return true;
  }

  get staticComplete(): boolean {
    return this.#here(this.#statics, true);
  }

  /** True if the whole scene was received: evicted chunks can be fetched. A growing scene is never complete. */
  get complete(): boolean {
    return this.manifest.live === null && this.states.size === this.#layers.size;
  }

  /** The playable stretches of time, as disjoint [start, end] in order. */
  ranges(): [number, number][] {
    const { slices, start, end } = this.manifest;
    if (slices.length === 0) return [[start, end]];
    const ranges: [number, number][] = [];
    for (const [i, slice] of slices.entries()) {
      if (!this.#here(chunksOf(slice), false)) continue;
      const until = slices[i + 1]?.start ?? end;
      const last = ranges.at(-1);
      if (last && last[1] >= slice.start) last[1] = until;
      else ranges.push([slice.start, until]);
    }
    return ranges;
  }

  #shownAt(time: number): string[] {
    const slice = this.manifest.slices[sliceAt(this.manifest.slices, time)];
    return slice ? chunksOf(slice) : [];
  }

  get #statics(): string[] {
    return this.manifest.static.map((chunk) => chunk.id);
  }

  /** Whether all of the chunks, or at least the base layers among them, are drawn or lost. */
  #here(ids: readonly string[], all: boolean): boolean {
    return ids.every((id) => this.states.settled(id) || (!all && this.#layers.get(id)?.layer !== 0));
  }
}
