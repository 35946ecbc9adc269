import { describe, expect, it } from "vitest";
import { ChunkOrder } from "../../src/source/chunk_order";
import { entry, manifest, slice } from "../scene";

// Every chunk has 100 bytes. Of each slice the first chunk is the base; of what stands, s0 is.
const scene = manifest({
  end: 15,
  static: ["s0", "s1", "s2", "s3"].map((id) => entry(id)),
  slices: Array.from({ length: 10 }, (_, k) => slice(1.5 * k, 1.5 * k + 1.5, [`a${k}`, `b${k}`, `c${k}`])),
});

/** The first of the order for a playhead at `time`, on a line of `line` bytes per second. */
function order({ time = 0 as number | null, rate = 1, line = 0, here = [] as string[], of = scene, count = 8 } = {}) {
  const missing = new ChunkOrder(of).missing({ time, rate }, line, (id) => here.includes(id));
  return [...missing]
    .slice(0, count)
    .map((chunk) => chunk.id)
    .join(" ");
}

const bases = ["s0", "a0", "a1", "a2"];

describe("the order of chunks", () => {
  it("begins with the room and what moves in it, and the bases of the next seconds", () => {
    expect(order({ count: 4 })).toBe("s0 a0 a1 a2");
    expect(order({ time: null, count: 2 })).toBe("s0 a0");
    expect(order({ time: 7.9, here: ["s0"], count: 3 })).toBe("a5 a6 a7");
  });

  it("brings what stands and what moves of a picture in turn", () => {
    const rich = manifest({
      static: [...["s0", "s1"].map((id) => entry(id)), { ...entry("s2"), bytes: 600 }],
      slices: [slice(0, 2, ["a", "b", "c", "d", "e", "f", "g", "h"])],
    });
    expect(order({ of: rich, count: 5 })).toBe("s0 a s1 b c");
  });

  it("refines the slices that come soon layer by layer, and what stands in turn", () => {
    expect(order({ here: bases })).toBe("s1 b0 s2 b1 s3 b2 c0 c1");
  });

  it("goes further ahead once the next seconds are complete", () => {
    const here = [...bases, "s1", "s2", "s3", "b0", "b1", "b2", "c0", "c1", "c2"];
    expect(order({ here })).toBe("a3 a4 a5 b3 b4 b5 c3 c4");
  });

  it("brings pages of the manifest before the bases of what comes sooner, but not long before their time", () => {
    const page = (start: number, id: string) => ({ ...slice(start, start + 2, []), chunks: [entry(id, 0)] });
    const slices = [slice(0, 2, ["a0"]), slice(2, 4, ["a1"]), page(4, "p0"), page(11, "p1"), page(14, "p2")];
    const paged = manifest({ end: 16, static: [entry("s0")], slices });
    expect(order({ of: paged })).toBe("s0 a0 p0 p1 a1 p2");
  });

  it("goes further ahead where the scene plays faster", () => {
    expect(order({ rate: 2, count: 6 })).toBe("s0 a0 a1 a2 a3 a4");
  });

  it("needs the beginning near the end", () => {
    expect(order({ time: 14.25, count: 4 })).toBe("s0 a9 a0 a1");
  });

  it("leaves a refinement for later that would come when its slice is over", () => {
    const here = ["s0", "s1", "s2", "s3", "a0", "a1", "a2"];
    expect(order({ time: 0.9, line: 100_000, here, count: 2 })).toBe("b1 b2"); // 64 KiB take 0.65 s
    expect(order({ time: 0.9, line: 1e6, here, count: 2 })).toBe("b0 b1");
    expect(order({ time: 0.9, rate: 0, line: 100_000, here, count: 1 })).toBe("b0");
  });

  it("brings what a slice needs of the ones before it", () => {
    const of = manifest({ slices: [slice(0, 1, ["a", "b"]), slice(1, 2, ["c", "d"], ["a", "b"])] });
    expect(order({ of, time: 1.5 })).toBe("a c b d");
  });

  it("asks for every chunk once, and for none that is here", () => {
    const all = order({ count: 100 }).split(" ");
    expect(all.length).toBe(34);
    expect(new Set(all).size).toBe(34);
    expect(order({ here: all })).toBe("");
  });

  it("knows a still scene", () => {
    expect(order({ of: manifest({ static: [entry("a"), entry("b")] }) })).toBe("a b");
  });
});
