import { describe, expect, it } from "vitest";
import { mergeBackToFront, RadixSorter, type SortedSplats } from "../../src/worker/sort";

const bits = (values: number[]) => new Uint32Array(new Float32Array(values).buffer);
const list = (depths: number[], ids: number[]): SortedSplats => ({
  keys: bits(depths),
  ids: new Uint32Array(ids),
  count: ids.length,
});

/** Deterministic pseudo-random numbers in [0, 1) (a linear congruential generator). */
function random(seed: number): () => number {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}

describe("RadixSorter", () => {
  it("sorts positive floats by their bits as Array.sort does", () => {
    const next = random(1);
    const depths = Array.from({ length: 10000 }, () => Math.fround(10 ** (6 * next() - 2)));
    const keys = bits(depths);
    const ids = Uint32Array.from(depths, (_, i) => i);
    new RadixSorter().sort(keys, ids, ids.length);
    const expected = depths.map((depth, id) => ({ depth, id })).sort((a, b) => a.depth - b.depth || a.id - b.id);
    expect(Array.from(ids)).toEqual(expected.map(({ id }) => id));
    expect(Array.from(new Float32Array(keys.buffer))).toEqual(expected.map(({ depth }) => depth));
  });

  it("tells neighbouring floats apart", () => {
    const keys = Uint32Array.of(0x41000001, 0x41000000, 0x41000002);
    const ids = Uint32Array.of(0, 1, 2);
    new RadixSorter().sort(keys, ids, 3);
    expect(Array.from(ids)).toEqual([1, 0, 2]);
  });

  it("keeps the order of equal keys", () => {
    const keys = bits([2, 1, 2, 1, 2]);
    const ids = Uint32Array.of(10, 11, 12, 13, 14);
    new RadixSorter().sort(keys, ids, 5);
    expect(Array.from(ids)).toEqual([11, 13, 10, 12, 14]);
  });

  it("leaves what lies behind the count alone, and sorts short after long", () => {
    const sorter = new RadixSorter();
    sorter.sort(bits([3, 2, 1]), Uint32Array.of(0, 1, 2), 3);
    const keys = bits([2, 1, 0.5]);
    const ids = Uint32Array.of(7, 8, 9);
    sorter.sort(keys, ids, 2);
    expect(Array.from(ids)).toEqual([8, 7, 9]);
  });
});

describe("mergeBackToFront", () => {
  it("writes the farthest first", () => {
    const out = new Uint32Array(5);
    const count = mergeBackToFront(list([1, 3, 5], [0, 1, 2]), list([2, 4], [10, 11]), out);
    expect(count).toBe(5);
    expect(Array.from(out)).toEqual([2, 11, 1, 10, 0]);
  });

  it("puts the first list in front at equal depth", () => {
    const out = new Uint32Array(2);
    mergeBackToFront(list([1], [0]), list([1], [10]), out);
    expect(Array.from(out)).toEqual([10, 0]);
  });

  it("merges with an empty list", () => {
    const out = new Uint32Array(2);
    mergeBackToFront(list([], []), list([1, 2], [5, 6]), out);
    expect(Array.from(out)).toEqual([6, 5]);
  });
});
