/** Which slice of a scene is shown when, and which chunks it needs. */

import type { SliceEntry } from "./types";

/** The index of the slice that is shown at `time`: the last that has started, or the first; -1 if there is none. */
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
