import { describe, expect, it } from "vitest";
import type { DecodedChunk, DynamicChunk } from "../../src/codec/types";
import { DYNAMIC_BIT, placeStatics } from "../../src/renderer/layout";
import type { SplatDepth } from "../../src/worker/depth";
import { SplatOrderer } from "../../src/worker/splat_order";
import { random } from "../random";
import { dynamicChunk, entry, manifest, slice, staticChunk } from "../scene";

const AXIS: SplatDepth = { kind: "planar", x: 0, y: 0, z: 1, offset: 0, near: 0.01 };
const dynamic = (i: number) => (DYNAMIC_BIT | i) >>> 0;

function orderer(statics: number[], chunk = dynamicChunk([], [], [], 0)): SplatOrderer {
  const m = manifest({ static: [entry("s", statics.length / 3)], slices: [slice(0, 2, ["d"])] });
  const made = new SplatOrderer(m, placeStatics(m));
  made.add("s", staticChunk(statics));
  made.add("d", chunk, [0]);
  return made;
}

const drawn = (o: SplatOrderer, time = 0, depth: SplatDepth = AXIS) => {
  const { ids, count } = o.order({
    depth,
    frustum: null,
    budget: Infinity,
    exact: true,
    time,
    from: time,
    until: time,
  });
  return Array.from(ids.subarray(0, count));
};

describe("SplatOrderer", () => {
  it("draws the farthest static first", () => {
    expect(drawn(orderer([0, 0, 1, 0, 0, 3, 0, 0, 2]))).toEqual([1, 2, 0]);
  });

  it("leaves out what lies before the camera's near plane", () => {
    const o = orderer([0, 0, 1, 0, 0, 0.009, 0, 0, -2]);
    expect(drawn(o)).toEqual([0]);
    expect(drawn(o, 0, { ...AXIS, near: 0.005 })).toEqual([0, 1]);
  });

  it("sorts by the distance from a point, with what lies behind it, and leaves out what is too close", () => {
    const o = orderer([0, 0, 2, 0, 0, -3, 1, 0, 0, 0, 0.09, 0], dynamicChunk([2.5], [0], [0], -9));
    const head: SplatDepth = { kind: "radial", x: 0, y: 0, z: 0, near: 0.1 };
    expect(drawn(o, 0, head)).toEqual([1, dynamic(0), 0, 2]);
    expect(drawn(o, 0, { ...head, near: 0.05 })).toEqual([1, dynamic(0), 0, 2, 3]);
    expect(drawn(o, 0, { ...head, z: 2 })).toEqual([1, 2, 3, dynamic(0)]); // the splat at the head's place is too close
  });

  it("sorts dynamics where they have moved to, with a camera that stands still", () => {
    const o = orderer([0, 0, 2], dynamicChunk([1], [4], [0], 0));
    expect(drawn(o, 0)).toEqual([0, dynamic(0)]); // at z = 1
    expect(drawn(o, 1)).toEqual([dynamic(0), 0]); // t = 0.5: at z = 3
  });

  it("follows motion to the fifth order", () => {
    const o = orderer([0, 0, 2], dynamicChunk([1, 1], [0, 0], [0, 0], -9, [0, 2]));
    expect(drawn(o, 0)).toEqual([0, dynamic(1), dynamic(0)]); // both at z = 1
    expect(drawn(o, 2)).toEqual([dynamic(1), 0, dynamic(0)]); // t = 1: one at z = 3
  });

  it("leaves out dynamics that are not alive", () => {
    // sigma = 0.5, s = e^4: visible for |d| <= sqrt(ln(127.5) / e^4) = 0.298
    const o = orderer([], dynamicChunk([1, 1], [0, 0], [0, 0.5], 4));
    expect(drawn(o, 0)).toEqual([dynamic(0)]);
    expect(drawn(o, 0.595)).toEqual([dynamic(1), dynamic(0)]);
    expect(drawn(o, 0.597)).toEqual([dynamic(1)]);
  });

  it("holds what is alive at any moment of an interval, sorted as at its time", () => {
    const o = orderer([], dynamicChunk([1, 2, 3], [0, 0, 0], [0, 0.5, 1], 4)); // seen for 0.298 about their centres
    const ids = (time: number, from: number, until: number) => {
      const order = o.order({ depth: AXIS, frustum: null, budget: Infinity, exact: true, time, from, until });
      return Array.from(order.ids.subarray(0, order.count));
    };
    expect(ids(0.5, 0.5, 0.5)).toEqual([dynamic(1), dynamic(0)]); // in normalised time: 0.25
    expect(ids(0.7, 0.5, 0.7)).toEqual([dynamic(1), dynamic(0)]);
    expect(ids(0.7, 0.61, 0.7)).toEqual([dynamic(1)]);
    expect(ids(0.5, 0.5, 1.5)).toEqual([dynamic(2), dynamic(1), dynamic(0)]);
  });

  it("takes an interval's splats from all slices of the segment, and from no other segment", () => {
    const segments = [
      { start: 0, end: 1 },
      { start: 1, end: 2 },
    ];
    const slices = [slice(0, 0.5, ["a"], [], 0), slice(0.5, 1, ["b"], [], 0), slice(1, 2, ["c"], [], 1)];
    const m = manifest({ segments, slices });
    const o = new SplatOrderer(m, placeStatics(m));
    ["a", "b", "c"].forEach((id, row) => {
      o.add(id, dynamicChunk([1], [0], [0.5], -9), [row]);
    });
    const { count } = o.order({
      depth: AXIS,
      frustum: null,
      budget: Infinity,
      exact: true,
      time: 0.4,
      from: 0.4,
      until: 1,
    });
    expect(count).toBe(2);
  });

  it("puts statics in front of dynamics, and low ids before high ones, at equal depth", () => {
    const o = orderer([0, 0, 1, 0, 0, 1], dynamicChunk([1, 1], [0, 0], [0, 0], 0));
    expect(drawn(o)).toEqual([dynamic(1), dynamic(0), 1, 0]);
  });

  it("sorts statics anew when the camera has moved", () => {
    const o = orderer([0, 0, 1, 0, 0, 3]);
    drawn(o);
    expect(drawn(o, 0, { ...AXIS, z: -1, offset: 5 })).toEqual([0, 1]);
  });

  it("shows statics that came after the last sort", () => {
    const m = manifest({ static: [entry("a"), entry("b")] });
    const o = new SplatOrderer(m, placeStatics(m));
    o.add("b", staticChunk([0, 0, 1]));
    expect(drawn(o)).toEqual([512]);
    o.add("a", staticChunk([0, 0, 1]));
    expect(drawn(o)).toEqual([512, 0]);
  });

  it("shows the dynamics of the segment of the time alone, at its normalised time", () => {
    const m = manifest({
      end: 4,
      segments: [
        { start: 0, end: 2 },
        { start: 2, end: 4 },
      ],
      slices: [slice(0, 2, ["a"], [], 0), slice(2, 4, ["b"], [], 1)],
    });
    const o = new SplatOrderer(m, placeStatics(m));
    o.add("a", dynamicChunk([1], [0], [0.5], -9), [0]);
    o.add("b", dynamicChunk([1], [0], [0.5], -9), [1]);
    expect(drawn(o, 1)).toEqual([dynamic(0)]);
    expect(drawn(o, 3)).toEqual([dynamic(256)]);
  });

  it("leaves out what the picture cannot show", () => {
    const o = orderer([0, 0, 1, 50, 0, 1], dynamicChunk([1], [0], [0], -9));
    const frustum = [{ x: 1, y: 0, z: 0, offset: -10, spread: 1 }];
    const order = o.order({ depth: AXIS, frustum, budget: Infinity, exact: true, time: 0, from: 0, until: 0 });
    expect([order.count, order.dynamic]).toEqual([2, 0]); // the statics are neighbours, and kept or left out together
  });

  it("orders a moving view as a standing one but for splats of all but the same depth", () => {
    const next = random(3);
    const means = Array.from({ length: 600 }, (_, i) => (i % 3 === 2 ? 1 + 4 * next() : next() - 0.5));
    const depths = Array.from({ length: 100 }, () => 1 + 4 * next());
    const zeros = depths.map(() => 0);
    const o = orderer(means, dynamicChunk(depths, zeros, zeros, -9));
    for (const depth of [AXIS, { kind: "radial", x: 0.1, y: 0.2, z: 0, near: 0.1 }] as const) {
      const order = (exact: boolean) =>
        o.order({ depth, frustum: null, budget: Infinity, exact, time: 0, from: 0, until: 0 });
      const [quick, slow] = [order(false), order(true)];
      expect(quick.dynamic).toBe(100);
      expect(Array.from(quick.ids)).toEqual(Array.from(slow.ids)); // of so few none are that close
      expect(order(false)).toEqual(quick);
    }
  });

  it("tells splats of all but the same depth apart once the view stands", () => {
    const next = 3 + 2 ** -22; // the next float
    const o = orderer([0, 0, next, 0, 0, 3, 0, 0, 0.1, 0, 0, 1e6]);
    const order = (exact: boolean) =>
      o.order({ depth: AXIS, frustum: null, budget: Infinity, exact, time: 0, from: 0, until: 0 }).ids;
    expect(Array.from(order(true).subarray(0, 4))).toEqual([3, 0, 1, 2]);
    expect(Array.from(order(false).subarray(0, 4))).toEqual([3, 1, 0, 2]);
  });

  it("takes up splats that come while the view moves", () => {
    const m = manifest({ static: [entry("a"), entry("b")] });
    const o = new SplatOrderer(m, placeStatics(m));
    const request = { depth: AXIS, frustum: null, budget: Infinity, exact: false, time: 0, from: 0, until: 0 };
    o.add("b", staticChunk([0, 0, 1]));
    expect(o.order(request).count).toBe(1);
    o.add("a", staticChunk([0, 0, 2]));
    expect(o.order({ ...request, exact: true }).count).toBe(2);
    expect(o.order(request).count).toBe(2);
  });

  it("names the splats of a chunk by the rows that it was given, in the order of the chunk at equal depth", () => {
    const m = manifest({ slices: [slice(0, 2, ["a", "b"])] });
    const o = new SplatOrderer(m, placeStatics(m));
    const many = Array.from({ length: 300 }, () => 1);
    const zeros = many.map(() => 0);
    o.add("b", dynamicChunk([1], [0], [0], -9), [0]);
    o.add("a", dynamicChunk(many, zeros, zeros, -9), [5, 2]);
    const expected = [...many.keys()].map((i) => dynamic(i < 256 ? 5 * 256 + i : 2 * 256 + i - 256));
    expect(drawn(o)).toEqual([...expected, dynamic(0)].reverse());
    o.evict("a");
    expect(drawn(o)).toEqual([dynamic(0)]);
  });

  it("writes into a recycled array that is long enough", () => {
    const o = orderer([0, 0, 1]);
    const request = { depth: AXIS, frustum: null, budget: Infinity, exact: true, time: 0, from: 0, until: 0 };
    const first = o.order(request);
    expect(o.order(request, first.ids).ids).toBe(first.ids);
  });

  describe("with a budget", () => {
    const allowing = <T extends DecodedChunk>(chunk: T, rgb: number): T => ({
      ...chunk,
      bounds: { ...chunk.bounds, rgb },
    });
    const request = { depth: AXIS, frustum: null, exact: true, time: 0, from: 0, until: 0 };
    const taken = (o: SplatOrderer, budget: number, time = 0, exact = true) => {
      const order = o.order({ ...request, budget, exact, time, from: time, until: time });
      return { ids: Array.from(order.ids.subarray(0, order.count)), dynamic: order.dynamic };
    };

    /** Six statics in two chunks, the second of which shows more, and what moves in a third. */
    function scene(moving: DynamicChunk): SplatOrderer {
      const m = manifest({ static: [entry("a", 3), entry("b", 3)], slices: [slice(0, 2, ["d"])] });
      const o = new SplatOrderer(m, placeStatics(m));
      o.add("a", allowing(staticChunk([0, 0, 1, 0, 0, 2, 0, 0, 3]), 0.02));
      o.add("b", allowing(staticChunk([0, 0, 4, 0, 0, 5, 0, 0, 6]), 0.01));
      o.add("d", moving, [0]);
      return o;
    }

    it("that is large enough gives the same order as none", () => {
      for (const exact of [true, false]) {
        const o = scene(allowing(dynamicChunk([1.5, 2.5], [0, 0], [0, 0], -9), 0.04));
        const all = taken(o, Infinity, 0, exact);
        expect(all.ids).toHaveLength(8);
        expect(taken(o, 8, 0, exact)).toEqual(all);
        expect(taken(o, 7, 0, exact).ids.length).toBeLessThan(8);
        expect(taken(o, 8, 0, exact)).toEqual(all);
      }
    });

    it("takes the most useful statics and dynamics, farthest first", () => {
      for (const exact of [true, false]) {
        const o = scene(allowing(dynamicChunk([1.5, 4.5], [0, 0], [0, 0], -9), 0.005));
        expect(taken(o, 5, 0, exact)).toEqual({ ids: [514, 513, dynamic(1), 512, dynamic(0)], dynamic: 2 });
        expect(taken(o, 2, 0, exact)).toEqual({ ids: [dynamic(1), dynamic(0)], dynamic: 2 });
      }
    });

    it("counts what moves for four times as much as what does not", () => {
      for (const [rgb, dynamics] of [
        [0.018, 1],
        [0.022, 0],
      ]) {
        const o = scene(allowing(dynamicChunk([1.5], [0], [0], -9), rgb));
        expect(taken(o, 1).dynamic).toBe(dynamics); // the best statics may be wrong by 0.01
      }
    });

    it("takes what is shown for a short time only before what is always shown, and not what has faded", () => {
      // s = e^8: the fade's square lasts for 0.023 of the segment, so that utility is 43 times the mean then.
      const o = scene(allowing(dynamicChunk([1.5, 2.5], [0, 0], [0, 0.02], 8), 0.08));
      expect(taken(o, 4)).toEqual({ ids: [514, 513, 512, dynamic(0)], dynamic: 1 }); // the other has e^-1.2 of its alpha
      expect(taken(o, 4, 0.04)).toEqual({ ids: [514, 513, 512, dynamic(1)], dynamic: 1 });
    });

    it("leaves out nothing for what the picture cannot show", () => {
      const o = scene(allowing(dynamicChunk([1], [0], [0], -9), 1e-4));
      const frustum = [{ x: 0, y: 0, z: 1, offset: -1.5, spread: 0 }]; // dynamics are looked at one by one
      const order = o.order({ ...request, frustum, budget: 6 });
      expect([order.count, order.dynamic]).toEqual([6, 0]);
    });
  });
});
