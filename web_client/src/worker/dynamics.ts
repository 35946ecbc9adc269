/** The splats of a chunk that move: which of them are alive when, and where. */

import type { DynamicChunk } from "../codec/types";
import { DYNAMIC_BIT, DYNAMICS_PER_ROW } from "../renderer/layout";
import type { SplatDepth } from "./depth";
import { type Frustum, mayShow, reachOf } from "./frustum";
import type { DepthList } from "./sort";
import { levelOf, utilityOf } from "./splat_budget";

const ROW_BITS = Math.log2(DYNAMICS_PER_ROW);
/** Octaves of utility by which splats that move count for more: people look at them. */
const MOVES = 2;
const CUBIC = 12; // numbers of a motion that goes no further

export class Dynamics {
  readonly count: number;
  readonly #motion: Float32Array;
  readonly #centers: Float32Array;
  /** ln(255 sigma) / s: the square of how far from its centre in time a splat can be seen. */
  readonly #lives: Float32Array;
  readonly #reaches: Float32Array; // world units
  readonly #precisions: Float32Array; // s
  readonly #utility: number; // octaves, of a splat that is shown all the time

  /** @param rows of the texture, which hold its splats one after the other. */
  constructor(
    readonly rows: readonly number[],
    { count, motion, timeCenters, timeLogPrecisions, opacities, logScales, bounds }: DynamicChunk,
  ) {
    this.count = count;
    this.#motion = motion;
    this.#centers = timeCenters;
    this.#lives = new Float32Array(count);
    this.#reaches = new Float32Array(count);
    this.#precisions = new Float32Array(count);
    this.#utility = utilityOf(bounds) + MOVES;
    for (let i = 0; i < count; i++) {
      this.#precisions[i] = Math.exp(timeLogPrecisions[i]);
      this.#lives[i] = Math.log(255 * opacities[i]) / this.#precisions[i];
      this.#reaches[i] = reachOf(opacities[i], logScales[3 * i], logScales[3 * i + 1], logScales[3 * i + 2]);
    }
  }

  /**
   * Write how useful its splats are at `t`, normalised, as levels of a `SplatBudget` by their places. Chunks tell of means over
   * the whole scene: a splat that is shown for a tenth of it shows ten times as much then, and less while it fades.
   */
  writeLevels(levels: Uint8Array, t: number): void {
    for (let i = 0; i < this.count; i++) {
      const s = this.#precisions[i];
      const d = t - this.#centers[i];
      const shown = Math.min(0, 0.5 * Math.log2(Math.PI / (2 * s))); // of the square of exp(-s d^2)
      levels[this.#place(i)] = levelOf(this.#utility - shown - 2 * Math.LOG2E * s * d * d);
    }
  }

  /** The first place in the texture behind all of its splats. */
  get end(): number {
    return (Math.max(-1, ...this.rows) + 1) * DYNAMICS_PER_ROW;
  }

  /** Where in the texture a splat is. */
  #place(i: number): number {
    return this.rows[i >> ROW_BITS] * DYNAMICS_PER_ROW + (i & (DYNAMICS_PER_ROW - 1));
  }

  /** Add those that are alive at any time from `from` until `until` and may show where they are at `t`; normalised times. */
  addTo(list: DepthList, by: SplatDepth, frustum: Frustum | null, t: number, from: number, until: number): void {
    const { depths, ids } = list;
    const { count } = this;
    const motion = this.#motion;
    const centers = this.#centers;
    const lives = this.#lives;
    const reaches = this.#reaches;
    const planar = by.kind === "planar";
    const offset = planar ? by.offset : 0;
    const nearest = planar ? by.near : by.near * by.near;
    const width = motion.length / count;
    const fifth = width > CUBIC;
    let n = list.count;
    for (let i = 0; i < count; i++) {
      const center = centers[i];
      const outside = center < from ? from - center : center > until ? center - until : 0;
      if (!(outside * outside <= lives[i])) continue;
      const d = t - center;
      const m = width * i;
      let cx = motion[m + 9];
      let cy = motion[m + 10];
      let cz = motion[m + 11];
      if (fifth) {
        cx += d * (motion[m + 12] + d * motion[m + 15]);
        cy += d * (motion[m + 13] + d * motion[m + 16]);
        cz += d * (motion[m + 14] + d * motion[m + 17]);
      }
      const x = motion[m] + d * (motion[m + 3] + d * (motion[m + 6] + d * cx));
      const y = motion[m + 1] + d * (motion[m + 4] + d * (motion[m + 7] + d * cy));
      const z = motion[m + 2] + d * (motion[m + 5] + d * (motion[m + 8] + d * cz));
      const depth = planar
        ? by.x * x + by.y * y + by.z * z + offset
        : (x - by.x) * (x - by.x) + (y - by.y) * (y - by.y) + (z - by.z) * (z - by.z);
      if (!(depth >= nearest) || (frustum !== null && !mayShow(frustum, x, y, z, reaches[i]))) continue;
      depths[n] = depth;
      ids[n++] = (DYNAMIC_BIT | this.#place(i)) >>> 0;
    }
    list.count = n;
  }
}
