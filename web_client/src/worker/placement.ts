/** Where the splats of every chunk of a manifest lie in the data textures: whole rows per chunk, in manifest order. */

import type { ChunkEntry, Manifest } from "../codec/types";
import { DYNAMICS_PER_ROW, STATICS_PER_ROW } from "../renderer/layout";

export interface Placement {
  /** Chunk id -> splat id of its first splat (without DYNAMIC_BIT); the others follow. */
  readonly first: ReadonlyMap<string, number>;
  readonly staticRows: number;
  readonly dynamicRows: number;
}

/** Statics and dynamics have id spaces, and textures, of their own. */
export function placeChunks(manifest: Manifest): Placement {
  const first = new Map<string, number>();
  const place = (chunks: readonly ChunkEntry[], perRow: number): number => {
    let row = 0;
    for (const chunk of chunks) {
      if (first.has(chunk.id)) continue;
      first.set(chunk.id, row * perRow);
      row += Math.ceil(chunk.splats / perRow);
    }
    return row;
  };
  const staticRows = place(manifest.static, STATICS_PER_ROW);
  const dynamicRows = place(
    manifest.slices.flatMap((slice) => slice.chunks),
    DYNAMICS_PER_ROW,
  );
  return { first, staticRows, dynamicRows };
}
