import { expect, it } from "vitest";
import { chunkOrder, chunksOfPicture } from "../../src/source/chunk_order";
import { entry, manifest, slice } from "../scene";

// Every chunk has 100 bytes, every slice is shown for ten seconds.
const scene = manifest({
  end: 40,
  static: ["s0", "s1", "s2", "s3"].map((id) => entry(id)),
  slices: [slice(0, 10, ["a"]), slice(10, 20, ["b"], ["a"]), slice(20, 30, ["c"]), slice(30, 40, ["d"])],
});

/** @param rate of the playhead at `time`; the line brings `line` bytes per second. */
function order({ time = 0, rate = 1, line = 1e9, here = [] as string[], of = scene } = {}): string {
  return [...chunkOrder(of, { time, rate }, line, (id) => here.includes(id))].map((chunk) => chunk.id).join(" ");
}

it("begins with the first static chunk and the slice at the playhead", () => {
  expect(order()).toMatch(/^s0 a /);
  expect(order({ time: 35 })).toMatch(/^s0 d /);
  expect(order({ time: 25, here: ["s0"] })).toMatch(/^c /);
});

it("brings what a slice needs of the ones before it", () => {
  expect(order({ time: 15 })).toMatch(/^s0 b a /);
  expect(order({ time: 15, here: ["a"] })).not.toContain("a");
});

it("brings static chunks first where the line brings the slices in time all the same", () => {
  expect(order()).toBe("s0 a s1 s2 s3 b c d");
});

it("brings slices and static chunks in turn where the line is slow", () => {
  expect(order({ line: 10 })).toBe("s0 a s1 b s2 c s3 d");
});

it("brings static chunks first while the scene stands", () => {
  expect(order({ rate: 0, line: 10 })).toBe("s0 a s1 s2 s3 b c d");
});

it("goes on around the end", () => {
  expect(order({ time: 25 })).toBe("s0 c s1 s2 s3 d a b");
});

it("asks for every chunk once, and for none that is here", () => {
  const needs = [slice(0, 20, ["a"]), slice(20, 40, ["b"], ["a"])];
  expect(order({ of: { ...scene, slices: needs }, here: ["s1"] })).toBe("s0 a s2 s3 b");
  expect(order({ here: ["s0", "s1", "s2", "s3", "a", "b", "c", "d"] })).toBe("");
});

it("takes a scene that has not begun for one at its start", () => {
  const first = chunkOrder(scene, { time: null, rate: 1 }, 1e9, (id) => id === "s0").next();
  expect(first.value?.id).toBe("a");
});

it("knows what makes a picture: the first static chunk and the slice that is shown, with its needs", () => {
  expect([...chunksOfPicture(scene, 15)].sort()).toEqual(["a", "b", "s0"]);
  expect([...chunksOfPicture({ ...scene, static: [], slices: [] }, 15)]).toEqual([]);
});
