/** The order as it was made before blocks and bits were left out: a radix sort of all splats by all 32 bits, in three passes. */

import type { PlanarDepth } from "../src/worker/depth";

const BINS = 2048;

export class PlainOrderer {
  readonly #keys: Uint32Array;
  readonly #depths: Float32Array;
  readonly #ids: Uint32Array;
  readonly #otherKeys: Uint32Array;
  readonly #otherIds: Uint32Array;
  readonly #out: Uint32Array;
  readonly #bins = new Uint32Array(3 * BINS);

  constructor(readonly means: Float32Array) {
    const count = means.length / 3;
    this.#keys = new Uint32Array(count);
    this.#depths = new Float32Array(this.#keys.buffer);
    this.#ids = new Uint32Array(count);
    this.#otherKeys = new Uint32Array(count);
    this.#otherIds = new Uint32Array(count);
    this.#out = new Uint32Array(count);
  }

  order({ x, y, z, offset, near }: PlanarDepth): Uint32Array {
    const { means } = this;
    const depths = this.#depths;
    const out = this.#out;
    let count = 0;
    for (let i = 0, at = 0; at < means.length; i++, at += 3) {
      const depth = x * means[at] + y * means[at + 1] + z * means[at + 2] + offset;
      if (!(depth >= near)) continue;
      depths[count] = depth;
      this.#ids[count++] = i;
    }
    const ids = this.#sort(count);
    for (let i = 0; i < count; i++) out[count - 1 - i] = ids[i];
    return out;
  }

  #sort(count: number): Uint32Array {
    const bins = this.#bins.fill(0);
    for (let i = 0; i < count; i++) {
      const key = this.#keys[i];
      bins[key & 2047]++;
      bins[BINS + ((key >>> 11) & 2047)]++;
      bins[2 * BINS + (key >>> 22)]++;
    }
    let [fromKeys, toKeys] = [this.#keys, this.#otherKeys];
    let [fromIds, toIds] = [this.#ids, this.#otherIds];
    for (let pass = 0; pass < 3; pass++) {
      let sum = 0;
      for (let bin = pass * BINS; bin < (pass + 1) * BINS; bin++) {
        const size = bins[bin];
        bins[bin] = sum;
        sum += size;
      }
      for (let i = 0; i < count; i++) {
        const key = fromKeys[i];
        const at = bins[pass * BINS + ((key >>> (11 * pass)) & 2047)]++;
        toKeys[at] = key;
        toIds[at] = fromIds[i];
      }
      [fromKeys, toKeys] = [toKeys, fromKeys];
      [fromIds, toIds] = [toIds, fromIds];
    }
    this.#keys.set(fromKeys.subarray(0, count));
    this.#ids.set(fromIds.subarray(0, count));
    return this.#ids;
  }
}
