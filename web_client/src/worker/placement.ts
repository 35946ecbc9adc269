/** Where splats lie in the data textures. */

import type { ChunkEntry, Manifest } from "../codec/types";
import { DYNAMICS_PER_ROW, STATICS_PER_ROW } from "../renderer/layout";

export interface StaticPlacement {
  /** Chunk id -> id of its first splat; the others follow. */
  readonly first: ReadonlyMap<string, number>;
  readonly rows: number;
}

/** Statics stay: whole rows per chunk, in manifest order. */
export function placeStatics(manifest: Manifest): StaticPlacement {
  const first = new Map<string, number>();
  let rows = 0;
  for (const chunk of manifest.static) {
    first.set(chunk.id, rows * STATICS_PER_ROW);
    rows += Math.ceil(chunk.splats / STATICS_PER_ROW);
  }
  return { first, rows };
}

/** Dynamics come and go: so many rows of a texture, whichever are free. */
export const rowsOf = ({ splats }: Pick<ChunkEntry, "splats">): number => Math.ceil(splats / DYNAMICS_PER_ROW);
