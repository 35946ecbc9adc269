/** The chunks of a manifest: the slice shown at a time, its chunks, and their layers (docs/format.md, "Layers"). */

import type { ChunkEntry, Manifest, SliceEntry } from "./types";

/** The index of the slice shown at `time`: the last that has started, or else the first; -1 if there is none. */
export function sliceAt(slices: readonly SliceEntry[], time: number): number {
  let low = 0;
  let high = slices.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (slices[middle].start <= time) low = middle + 1;
    else high = middle;
  }
  return slices.length === 0 ? -1 : Math.max(0, low - 1);
}

/** The ids of all chunks that hold splats alive in a slice; those of earlier slices come first. */
export const chunksOf = (slice: SliceEntry): string[] => [...slice.needs, ...slice.chunks.map((chunk) => chunk.id)];

/** The ids of all chunks that hold splats alive at any time from `from` until `until`, seconds. */
export function chunksBetween(slices: readonly SliceEntry[], from: number, until: number): string[] {
  const [first, last] = [sliceAt(slices, from), sliceAt(slices, until)];
  return first < 0 ? [] : slices.slice(first, last + 1).flatMap(chunksOf);
}

/** The base has at least a fourth of the bytes of the static chunks, and a third of those of a slice. */
const STATIC_PART = 4;
const SLICE_PART = 3;

export interface Layered {
  readonly chunk: ChunkEntry;
  /** 0 for the base of its list; 1 and above for refinements. */
  readonly layer: number;
}

/** Every chunk by its id. */
export function layersOf({ static: stills, slices }: Manifest): ReadonlyMap<string, Layered> {
  const layers = new Map<string, Layered>();
  const add = (chunks: readonly ChunkEntry[], part: number): void => {
    let lacking = chunks.reduce((sum, { bytes }) => sum + bytes, 0); // bytes that the base still lacks, times `part`
    let layer = 0;
    for (const chunk of chunks) {
      if (lacking <= 0) layer++;
      lacking -= part * chunk.bytes;
      layers.set(chunk.id, { chunk, layer });
    }
  };
  add(stills, STATIC_PART);
  for (const { chunks } of slices) add(chunks, SLICE_PART);
  return layers;
}
