/** The layout of splats in the data textures, and further numbers that the worker and the shaders share. */

import type { ChunkEntry, Manifest } from "../codec/types";

/** Binary digits of a texel's column in a data texture. */
const TEXTURE_BITS = 11;

/** Texels per row of every data texture. */
export const TEXTURE_WIDTH = 1 << TEXTURE_BITS;

/** RGBA32F texels of a static splat: [x y z opacity] [quaternion] [sigma x y z, -] [r g b, -]. */
export const STATIC_TEXELS = 4;

/**
 * RGBA32F texels of a dynamic splat: 3 of motion, 2 of rotation, [sigma, peak opacity] [r g b, mu] [s, q, -, -]. q is 1
 * if the motion continues to the fifth order, else 0.
 */
export const DYNAMIC_TEXELS = 8;

/**
 * RGBA32F texels of a dynamic splat in a separate texture, only for scenes with motions of the fifth order: [m4, -]
 * [m5, -].
 */
export const FIFTH_TEXELS = 2;

export const STATICS_PER_ROW = TEXTURE_WIDTH / STATIC_TEXELS;
export const DYNAMICS_PER_ROW = TEXTURE_WIDTH / DYNAMIC_TEXELS;

/** Texels per row of the texture of the fifth order: for as many splats as a row of dynamics. */
export const FIFTH_WIDTH = DYNAMICS_PER_ROW * FIFTH_TEXELS;

/** The bit that marks ids of dynamic splats. */
export const DYNAMIC_BIT = 0x80000000;

/** Whether an id is that of a dynamic splat. */
export const isDynamic = (id: number): boolean => id >= DYNAMIC_BIT;

/** Triangles per instance, one for each splat: small instances starve GPUs. */
export const TRIANGLES_PER_INSTANCE = 1024;

/** Variance that drawing adds to a splat on the screen (docs/numerics.md, Projection), pixels squared. */
export const LOW_PASS = 0.3;

/** The numbers above as definitions for the vertex shader of splats. */
export const LAYOUT_DEFINITIONS = `
#define TEXTURE_BITS ${TEXTURE_BITS}
#define TEXTURE_WIDTH ${TEXTURE_WIDTH}
#define STATIC_TEXELS ${STATIC_TEXELS}
#define DYNAMIC_TEXELS ${DYNAMIC_TEXELS}
#define FIFTH_TEXELS ${FIFTH_TEXELS}
#define FIFTH_WIDTH ${FIFTH_WIDTH}
#define DYNAMIC_BIT ${DYNAMIC_BIT}u
#define TRIANGLES_PER_INSTANCE ${TRIANGLES_PER_INSTANCE}u
#define LOW_PASS ${LOW_PASS}
`;

export interface StaticPlacement {
  /** Chunk id -> id of its first splat; the others follow. */
  readonly first: ReadonlyMap<string, number>;
  readonly rows: number;
}

/** The rows of static chunks: whole ones per chunk, in manifest order. */
export function placeStatics(manifest: Manifest): StaticPlacement {
  const first = new Map<string, number>();
  let rows = 0;
  for (const chunk of manifest.static) {
    first.set(chunk.id, rows * STATICS_PER_ROW);
    rows += Math.ceil(chunk.splats / STATICS_PER_ROW);
  }
  return { first, rows };
}

/** Number of texture rows for a dynamic chunk; any free ones will do. */
export const rowsOf = ({ splats }: Pick<ChunkEntry, "splats">): number => Math.ceil(splats / DYNAMICS_PER_ROW);
