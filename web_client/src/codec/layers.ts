/** Which chunks a picture begins with, and which refine it (docs/format.md, "Layers"). */

import type { ChunkEntry, Manifest } from "./types";

/** The base of the static chunks has at least a fourth of their bytes, and that of a slice's a third. */
const STATIC_PART = 4;
const SLICE_PART = 3;

export interface Layered {
  readonly chunk: ChunkEntry;
  /** 0 is the base of its list; 1 and above refine it. */
  readonly layer: number;
}

/** Every chunk by its id. */
export function layersOf({ static: stills, slices }: Manifest): ReadonlyMap<string, Layered> {
  const layers = new Map<string, Layered>();
  const add = (chunks: readonly ChunkEntry[], part: number): void => {
    let lacking = chunks.reduce((sum, { bytes }) => sum + bytes, 0); // of the base, times `part`
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
