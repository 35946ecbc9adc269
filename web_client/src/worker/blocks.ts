/** Static splats, in blocks that are skipped as a whole where the picture shows none of their splats. */

import type { StaticChunk } from "../codec/types";
import type { SplatDepth } from "./depth";
import { type Frustum, reachOf } from "./frustum";

/** Splats of a block. Chunks are in Morton order, so that splats of a block are neighbours. */
export const BLOCK = 256;

export class StaticBlocks {
  readonly count: number;
  readonly means: Float32Array;
  /** Per block: the middle of its box, half its sides, and the longest reach. */
  readonly #bounds: Float64Array;

  /**
   * Divide a chunk into blocks.
   *
   * @param first id of its first splat.
   */
  constructor(
    readonly first: number,
    { count, means, opacities, logScales }: StaticChunk,
  ) {
    this.count = count;
    this.means = means;
    this.#bounds = new Float64Array(7 * Math.ceil(count / BLOCK));
    for (let begin = 0, at = 0; begin < count; begin += BLOCK, at += 7) {
      const end = Math.min(count, begin + BLOCK);
      const low = [Infinity, Infinity, Infinity];
      const high = [-Infinity, -Infinity, -Infinity];
      let reach = -1;
      for (let i = begin; i < end; i++) {
        for (let k = 0; k < 3; k++) {
          low[k] = Math.min(low[k], means[3 * i + k]);
          high[k] = Math.max(high[k], means[3 * i + k]);
        }
        reach = Math.max(reach, reachOf(opacities[i], logScales[3 * i], logScales[3 * i + 1], logScales[3 * i + 2]));
      }
      for (let k = 0; k < 3; k++) {
        this.#bounds[at + k] = (low[k] + high[k]) / 2;
        this.#bounds[at + 3 + k] = (high[k] - low[k]) / 2;
      }
      this.#bounds[at + 6] = reach;
    }
  }

  /** Whether the picture may show a splat of the block that begins with splat `begin`. */
  mayShow(begin: number, depth: SplatDepth, frustum: Frustum | null): boolean {
    const b = this.#bounds;
    const at = (7 * begin) / BLOCK;
    const reach = b[at + 6];
    if (reach < 0) return false;
    const inside = (x: number, y: number, z: number, offset: number) =>
      x * b[at] +
        y * b[at + 1] +
        z * b[at + 2] +
        Math.abs(x) * b[at + 3] +
        Math.abs(y) * b[at + 4] +
        Math.abs(z) * b[at + 5] +
        offset >=
      0;
    // A millionth of slack, for rounding errors of the sums.
    if (depth.kind === "planar" && !inside(depth.x, depth.y, depth.z, depth.offset - depth.near * (1 - 1e-6)))
      return false;
    if (frustum === null) return true;
    for (const { x, y, z, offset, spread } of frustum) if (!inside(x, y, z, offset + spread * reach)) return false;
    return true;
  }
}
