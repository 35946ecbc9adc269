import fc from "fast-check";
import { describe, expect, it } from "vitest";
import { DepthList, mergeBackToFront, type SortedSplats } from "../../src/worker/sort";
import { random } from "../random";

const bits = (values: number[]) => new Int32Array(new Float32Array(values).buffer);
const list = (depths: number[], ids: number[]): SortedSplats => ({
  keys: bits(depths),
  ids: new Uint32Array(ids),
  count: ids.length,
});

/** The list of (depth, index), sorted. */
function sorted(depths: readonly number[], made = new DepthList()): DepthList {
  made.reset(depths.length);
  made.depths.set(depths);
  made.ids.set(depths.map((_, i) => i));
  made.count = depths.length;
  made.sort();
  return made;
}

const idsOf = ({ ids, count }: DepthList) => Array.from(ids.subarray(0, count));

/** As Array.sort sorts them. */
const expected = (depths: readonly number[]) =>
  depths
    .map((depth, id) => ({ depth: Math.fround(depth), id }))
    .sort((a, b) => a.depth - b.depth || a.id - b.id)
    .map(({ id }) => id);

describe("DepthList", () => {
  it.each([
    ["of a room", (u: number) => 1.5 + 4 * u],
    ["over many octaves", (u: number) => 10 ** (16 * u - 8)],
    ["that are all but equal", (u: number) => 5 + 1e-5 * u],
    ["of a room with one splat far away", (u: number, i: number) => (i === 77 ? 1e18 : 2 + u)],
    [
      "on one small place, with others near and far",
      (u: number, i: number) => (i % 500 === 0 ? 10 ** (8 * u) : 3 + 1e-3 * u),
    ],
    ["of few values", (u: number) => Math.floor(8 * u)],
    ["that are equal", () => 3],
    ["up to infinity", (u: number) => (u < 0.01 ? Infinity : u)],
  ])("sorts depths %s as Array.sort does, equal ones by index", (_, depthOf) => {
    const next = random(1);
    const depths = Array.from({ length: 20_000 }, (_, i) => depthOf(next(), i));
    const list = sorted(depths);
    expect(idsOf(list)).toEqual(expected(depths));
    expect(Array.from(list.depths.subarray(0, list.count))).toEqual(idsOf(list).map((id) => Math.fround(depths[id])));
  });

  it("sorts any list", () => {
    const depth = fc.oneof(fc.float({ min: 0, noNaN: true }), fc.constantFrom(0, 1, 1.0000001, 2));
    fc.assert(
      fc.property(fc.array(depth, { maxLength: 200 }), (depths) => {
        expect(idsOf(sorted(depths))).toEqual(expected(depths));
      }),
    );
  });

  it("writes quickly what is sorted but for depths that are all but the same", () => {
    const next = random(2);
    const depths = Float32Array.from({ length: 50_000 }, () => 10 ** (4 * next() - 1));
    const list = new DepthList();
    list.reset(depths.length);
    list.depths.set(depths);
    list.ids.set(depths.map((_, i) => i));
    list.count = depths.length;
    const out = new Uint32Array(depths.length);
    list.writeQuickly(out);
    expect(new Set(out).size).toBe(depths.length);
    for (let i = 1; i < out.length; i++) {
      const [back, front] = [out[i - 1], out[i]];
      expect(depths[front] / depths[back]).toBeLessThan(1 + 1e-5);
      if (depths[front] === depths[back]) expect(front).toBeLessThan(back);
    }
  });

  it("forgets what it held before", () => {
    const list = sorted([3, 2, 1]);
    expect(idsOf(sorted([2, 1], list))).toEqual([1, 0]);
    list.reset(0);
    list.sort();
    expect(list.count).toBe(0);
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
