/** Which chunks are here, and which moments can be shown with them. */

import { chunksOf, sliceAt } from "../codec/slices";
import type { Manifest, SliceEntry } from "../codec/types";

export class SceneBuffer {
  readonly #arrived = new Set<string>();
  readonly #away = new Set<string>(); // of those, what cannot be drawn now
  readonly #lost = new Set<string>();
  readonly #chunks: number; // of the whole scene

  constructor(readonly manifest: Manifest) {
    const all = [...manifest.static, ...manifest.slices.flatMap((slice) => slice.chunks)];
    this.#chunks = new Set(all.map((chunk) => chunk.id)).size;
  }

  /** Note that a chunk can be drawn from now on. */
  arrived(id: string): void {
    this.#arrived.add(id);
    this.#away.delete(id);
    this.#lost.delete(id);
  }

  /** Note that a chunk is here, but cannot be drawn yet. */
  delivered(id: string): void {
    if (this.#arrived.has(id)) return;
    this.#arrived.add(id);
    this.#away.add(id);
  }

  /** Note that a chunk has made room for others: it cannot be drawn until it arrives again. */
  evicted(id: string): void {
    this.#away.add(id);
  }

  /** Note that a chunk cannot be had: what else there is at its time is shown without it. */
  lose(id: string): void {
    if (!this.#arrived.has(id) || this.#away.has(id)) this.#lost.add(id);
  }

  /** How many chunks are shown without. */
  get lost(): number {
    return this.#lost.size;
  }

  /** True if every dynamic splat alive at `time` is here, or cannot be had. */
  ready(time: number): boolean {
    const slice = this.manifest.slices[sliceAt(this.manifest.slices, time)];
    return slice === undefined || this.#complete(slice);
  }

  get staticComplete(): boolean {
    return this.manifest.static.every((chunk) => this.#settled(chunk.id));
  }

  /** True if the whole scene is here, or was: what has made room since can be fetched. */
  get complete(): boolean {
    return this.#arrived.size === this.#chunks;
  }

  /** The stretches of time that are ready, as disjoint [start, end] in order. */
  ranges(): [number, number][] {
    const { slices, start, end } = this.manifest;
    if (slices.length === 0) return [[start, end]];
    const ranges: [number, number][] = [];
    for (const [i, slice] of slices.entries()) {
      if (!this.#complete(slice)) continue;
      const until = slices[i + 1]?.start ?? end;
      const last = ranges.at(-1);
      if (last && last[1] >= slice.start) last[1] = until;
      else ranges.push([slice.start, until]);
    }
    return ranges;
  }

  #complete(slice: SliceEntry): boolean {
    return chunksOf(slice).every((id) => this.#settled(id));
  }

  #settled(id: string): boolean {
    return (this.#arrived.has(id) && !this.#away.has(id)) || this.#lost.has(id);
  }
}
