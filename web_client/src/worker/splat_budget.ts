/**
 * The most useful splats of an order, for a budget of fewer splats. The bounds of a chunk define its splats'
 * visibility; among equally visible splats an evenly spread part remains.
 */

import type { Bounds } from "../codec/types";
import { DYNAMIC_BIT, isDynamic, STATICS_PER_ROW } from "../renderer/layout";

/** Levels per octave of utility, and number of levels. */
const STEPS = 4;
const LEVELS = 256;
/** The level of utility 1: 40 octaves lie above it, and 24 below. */
const ONE = 96;
/** Parts of the splats of a level. */
const PARTS = 256;
/** 2^32 over the golden ratio: its multiples, modulo 2^32, are evenly spread over any range. */
const GOLDEN = 0x9e3779b1;

/**
 * The visibility of a chunk's splats, in octaves of utility: squares of pictures' differences, so that twice the
 * allowed error means two octaves less (docs/format.md, Bounds).
 */
export const utilityOf = ({ rgb }: Bounds): number => -2 * Math.log2(rgb);

/** The level, 0 to 255, for octaves of utility; infinite ones get the last or the first. */
export const levelOf = (octaves: number): number =>
  Math.min(LEVELS - 1, Math.max(0, Math.round(ONE + STEPS * octaves)));

export class SplatBudget {
  readonly #statics: Uint8Array; // levels by row
  #dynamics = new Uint8Array(0); // levels by place
  readonly #bins = new Uint32Array(LEVELS * PARTS);

  /**
   * Start with no chunks.
   *
   * @param staticRows of the texture of the statics.
   */
  constructor(staticRows: number) {
    this.#statics = new Uint8Array(staticRows);
  }

  /** Note a static chunk by the id of its first splat. */
  addStatics(first: number, count: number, bounds: Bounds): void {
    const row = first / STATICS_PER_ROW;
    this.#statics.fill(levelOf(utilityOf(bounds)), row, row + Math.ceil(count / STATICS_PER_ROW));
  }

  /** The levels of dynamics by their places in the texture, for at least so many; to be written before a `cut`. */
  levels(places: number): Uint8Array {
    if (this.#dynamics.length < places) this.#dynamics = new Uint8Array(Math.ceil(places * 1.25));
    return this.#dynamics;
  }

  /** Keep the most useful of the first `count` ids, in their order, and return their number: at most `budget`. */
  cut(ids: Uint32Array, count: number, budget: number): number {
    if (count <= budget) return count;
    const bins = this.#bins.fill(0);
    for (let i = 0; i < count; i++) bins[this.#rank(ids[i])]++;
    let least = bins.length;
    for (let room = budget; least > 0 && bins[least - 1] <= room; least--) room -= bins[least - 1];
    let kept = 0;
    for (let i = 0; i < count; i++) if (this.#rank(ids[i]) >= least) ids[kept++] = ids[i];
    return kept;
  }

  /** The priority of a splat: its level, and its part of that level. */
  #rank(id: number): number {
    const level = isDynamic(id) ? this.#dynamics[id & ~DYNAMIC_BIT] : this.#statics[(id / STATICS_PER_ROW) | 0];
    return level * PARTS + (Math.imul(id, GOLDEN) >>> 24);
  }
}
