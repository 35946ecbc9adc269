/** Exact sorting by depth: lists of (depth, id), and the merge of two sorted ones. */

const DIGIT = 11;
const BINS = 1 << DIGIT;
const MASK = BINS - 1;
/** Bits sorted by two passes; insertion sorts the rest. */
const QUICK_BITS = 2 * DIGIT;
/** Most moves per splat by insertion; longer ones fall back to a sort by all bits. */
const MOST_MOVES = 2;

/** Splats sorted by ascending depth. */
export interface SortedSplats {
  readonly keys: Int32Array; // bits of the float32 depth
  readonly ids: Uint32Array;
  readonly count: number;
}

/**
 * A list of (depth, id) with its own sort; its memory is reused.
 *
 * Non-negative float32 numbers sort as their bits, so that depths beyond the near plane need no conversion. Only bits
 * in which the depths differ count: two passes of a radix sort handle the upper 22, insertion into the nearly sorted
 * list the few others.
 */
export class DepthList implements SortedSplats {
  count = 0;
  keys = new Int32Array(0);
  ids = new Uint32Array(0);
  /** The keys as floats: write the first `count` of them, and of `ids`, and sort. */
  depths = new Float32Array(0);
  #otherKeys = new Int32Array(0);
  #otherIds = new Uint32Array(0);
  #digits = new Uint16Array(0); // shares memory with the other keys
  readonly #bins = new Uint32Array(2 * BINS);

  /** Empty the list and make room for a number of splats. */
  reset(capacity: number): void {
    this.count = 0;
    this.makeRoom(capacity);
  }

  /** Make room for a number of further splats. */
  makeRoom(more: number): void {
    const capacity = this.count + more;
    if (this.keys.length >= capacity) return;
    const [keys, ids] = [this.keys.subarray(0, this.count), this.ids.subarray(0, this.count)];
    const length = Math.ceil(capacity * 1.25);
    this.keys = new Int32Array(length);
    this.ids = new Uint32Array(length);
    this.keys.set(keys);
    this.ids.set(ids);
    this.depths = new Float32Array(this.keys.buffer);
    this.#otherKeys = new Int32Array(length);
    this.#otherIds = new Uint32Array(length);
    this.#digits = new Uint16Array(this.#otherKeys.buffer);
  }

  /** Sort by ascending depth; equal depths keep their order. */
  sort(): void {
    const { low, shift } = this.#range();
    this.#twoPasses(low, shift);
    if (shift === 0 || this.#insert(MOST_MOVES * this.count)) return;
    this.#twoPasses(low, 0, MASK); // the lower 22 bits, then the upper ones
    this.#twoPasses(low, 32 - QUICK_BITS);
  }

  /**
   * Write the ids into `out`, farthest first, in about two thirds of the time; the list itself is left in disorder.
   * Depths that differ by less than a 2^22nd of the list's range count as equal.
   */
  writeQuickly(out: Uint32Array): void {
    const { keys, ids, count } = this;
    const { low, shift } = this.#range();
    const bins = this.#countDigits(low, shift, -1);
    const upper = shift + DIGIT;
    const digits = this.#digits;
    const otherIds = this.#otherIds;
    for (let i = 0; i < count; i++) {
      const key = keys[i] - low;
      const at = bins[(key >>> shift) & MASK]++;
      digits[at] = key >>> upper;
      otherIds[at] = ids[i];
    }
    const last = count - 1;
    for (let i = 0; i < count; i++) out[last - bins[BINS + digits[i]]++] = otherIds[i];
  }

  /** The lowest key, and the position of the upper 22 bits of the differences to it. */
  #range(): { low: number; shift: number } {
    const { keys, count } = this;
    let low = 0x7fffffff;
    let high = 0;
    for (let i = 0; i < count; i++) {
      const key = keys[i];
      if (key < low) low = key;
      if (key > high) high = key;
    }
    let shift = 0;
    while (count > 0 && (high - low) >>> shift >= 1 << QUICK_BITS) shift++;
    return { low, shift };
  }

  /** The starts of the digits: of the 11 bits of `key - low` from `shift` on, and of those above, cut by `mask`. */
  #countDigits(low: number, shift: number, mask: number): Uint32Array {
    const { keys, count } = this;
    const bins = this.#bins.fill(0);
    const upper = shift + DIGIT;
    for (let i = 0; i < count; i++) {
      const key = keys[i] - low;
      bins[(key >>> shift) & MASK]++;
      bins[BINS + ((key >>> upper) & mask)]++;
    }
    for (let offset = 0; offset < 2 * BINS; offset += BINS) {
      let sum = 0;
      for (let bin = offset; bin < offset + BINS; bin++) {
        const size = bins[bin];
        bins[bin] = sum;
        sum += size;
      }
    }
    return bins;
  }

  /** A radix sort by 22 bits of `key - low` from `shift` on; `mask` removes bits above them. */
  #twoPasses(low: number, shift: number, mask = -1): void {
    const { keys, ids, count } = this;
    const [otherKeys, otherIds] = [this.#otherKeys, this.#otherIds];
    const bins = this.#countDigits(low, shift, mask);
    const upper = shift + DIGIT;
    for (let i = 0; i < count; i++) {
      const key = keys[i];
      const at = bins[((key - low) >>> shift) & MASK]++;
      otherKeys[at] = key;
      otherIds[at] = ids[i];
    }
    for (let i = 0; i < count; i++) {
      const key = otherKeys[i];
      const at = bins[BINS + (((key - low) >>> upper) & mask)]++;
      keys[at] = key;
      ids[at] = otherIds[i];
    }
  }

  /**
   * Sort a nearly sorted list; returns false, and leaves the rest as it is, if that would take more than `most` moves.
   */
  #insert(most: number): boolean {
    const { keys, ids, count } = this;
    let moves = 0;
    let last = count > 0 ? keys[0] : 0;
    for (let i = 1; i < count; i++) {
      const key = keys[i];
      if (key >= last) {
        last = key;
        continue;
      }
      const id = ids[i];
      let at = i;
      do {
        keys[at] = keys[at - 1];
        ids[at] = ids[at - 1];
        at--;
      } while (at > 0 && keys[at - 1] > key);
      keys[at] = key;
      ids[at] = id;
      moves += i - at;
      if (moves > most) return false;
    }
    return true;
  }
}

/**
 * Merge two sorted lists into `out`, farthest first: the order of drawing.
 *
 * At equal depth the splats of `first` are in front, like statics in docs/numerics.md. Returns the number of ids.
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
