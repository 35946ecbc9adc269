/** The dynamic splats of a chunk: their lives and positions. */

import type { DynamicChunk } from "../codec/types";
import { DYNAMIC_BIT, DYNAMICS_PER_ROW } from "../renderer/layout";
import type { SplatDepth } from "./depth";
import { type Frustum, mayShow, reachOf } from "./frustum";
import type { DepthList } from "./sort";
import { levelOf, utilityOf } from "./splat_budget";

const ROW_BITS = Math.log2(DYNAMICS_PER_ROW);
/** Extra utility of dynamic splats, octaves: people look at them. */
const MOVES = 2;
const CUBIC = 12; // numbers of a motion without a fifth order

export class Dynamics {
  readonly count: number;
  readonly #motion: Float32Array;
  readonly #centers: Float32Array;
  /** ln(255 sigma) / s: the square of the time from its centre for which a splat is visible. */
  readonly #lives: Float32Array;
  readonly #reaches: Float32Array; // world units
  readonly #precisions: Float32Array; // s
  readonly #utility: number; // octaves, for a splat that is always visible

  /**
   * Take a chunk.
   *
   * @param rows of the texture with its splats, in sequence.
   */
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
   * Write the utilities of its splats at `t`, normalised, as levels of a `SplatBudget` by their places. A chunk's
   * bounds are means over the whole scene: a splat with a life of a tenth of it is ten times as visible then, and less
   * while it fades.
   */
  writeLevels(levels: Uint8Array, t: number): void {
    for (let i = 0; i < this.count; i++) {
      const s = this.#precisions[i];
      const d = t - this.#centers[i];
      const shown = Math.min(0, 0.5 * Math.log2(Math.PI / (2 * s))); // log2 of the integral of exp(-s d^2)^2
      levels[this.#place(i)] = levelOf(this.#utility - shown - 2 * Math.LOG2E * s * d * d);
    }
  }

  /** The first place in the texture behind its splats. */
  get end(): number {
    return (Math.max(-1, ...this.rows) + 1) * DYNAMICS_PER_ROW;
  }

  /** The place of a splat in the texture. */
  #place(i: number): number {
    return this.rows[i >> ROW_BITS] * DYNAMICS_PER_ROW + (i & (DYNAMICS_PER_ROW - 1));
  }

  /**
   * Add the splats that are alive at any time from `from` until `until` and may be visible at their positions at `t`;
   * normalised times.
   */
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
