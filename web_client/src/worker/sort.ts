/** Depth sorting by full 32-bit float keys: a stable radix sort of 11-bit digits, and the merge of two sorted lists. */

const DIGIT = 11;
const BINS = 1 << DIGIT;
const MASK = BINS - 1;

/** Sorts (key, value) pairs in place; keeps its scratch memory between calls. */
export class RadixSorter {
  #keys = new Uint32Array(0);
  #values = new Uint32Array(0);
  readonly #bins = new Uint32Array(3 * BINS);

  /**
   * Sort the first `count` pairs by ascending key; equal keys keep their order.
   *
   * A non-negative float32 sorts as its bits, so depths beyond the near plane need no conversion.
   */
  sort(keys: Uint32Array, values: Uint32Array, count: number): void {
    if (this.#keys.length < count) {
      this.#keys = new Uint32Array(count);
      this.#values = new Uint32Array(count);
    }
    const bins = this.#bins.fill(0);
    for (let i = 0; i < count; i++) {
      const key = keys[i];
      bins[key & MASK]++;
      bins[BINS + ((key >>> DIGIT) & MASK)]++;
      bins[2 * BINS + (key >>> (2 * DIGIT))]++;
    }
    let [fromKeys, toKeys] = [keys, this.#keys as Uint32Array];
    let [fromValues, toValues] = [values, this.#values as Uint32Array];
    for (let pass = 0; pass < 3; pass++) {
      const offset = pass * BINS;
      const shift = pass * DIGIT;
      let sum = 0;
      for (let b = offset; b < offset + BINS; b++) {
        const size = bins[b];
        bins[b] = sum;
        sum += size;
      }
      for (let i = 0; i < count; i++) {
        const key = fromKeys[i];
        const at = bins[offset + ((key >>> shift) & MASK)]++;
        toKeys[at] = key;
        toValues[at] = fromValues[i];
      }
      [fromKeys, toKeys] = [toKeys, fromKeys];
      [fromValues, toValues] = [toValues, fromValues];
    }
    keys.set(fromKeys.subarray(0, count));
    values.set(fromValues.subarray(0, count));
  }
}

/** Splats sorted by ascending depth. */
export interface SortedSplats {
  readonly keys: Uint32Array; // bits of the float32 depth
  readonly ids: Uint32Array;
  readonly count: number;
}

/**
 * Merge two sorted lists into `out`, farthest first: the order in which they are drawn.
 *
 * At equal depth the splats of `first` lie in front, as statics do in docs/numerics.md. Returns how many were written.
 */
export function mergeBackToFront(first: SortedSplats, second: SortedSplats, out: Uint32Array): number {
  const { keys: keysA, ids: idsA, count: countA } = first;
  const { keys: keysB, ids: idsB, count: countB } = second;
  let write = countA + countB;
  let a = 0;
  let b = 0;
  while (a < countA && b < countB) {
    out[--write] = keysA[a] <= keysB[b] ? idsA[a++] : idsB[b++];
  }
  while (a < countA) out[--write] = idsA[a++];
  while (b < countB) out[--write] = idsB[b++];
  return countA + countB;
}
