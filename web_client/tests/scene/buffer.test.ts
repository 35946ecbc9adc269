import { describe, expect, it } from "vitest";
import { SceneBuffer } from "../../src/scene/buffer";
import { draw, entry, manifest, slice } from "../scene";

const slices = [slice(0, 0.5, ["a"]), slice(0.5, 1, ["b"], ["a"]), slice(1, 2, ["c", "d"])];

describe("SceneBuffer", () => {
  it("is ready only where every chunk of the slice is here", () => {
    const buffer = new SceneBuffer(manifest({ slices }));
    draw(buffer, "c");
    expect(buffer.ready(1.5)).toBe(false);
    draw(buffer, "d");
    expect(buffer.ready(1.5)).toBe(true);
  });

  it("waits for the chunks of earlier slices that are still alive", () => {
    const buffer = new SceneBuffer(manifest({ slices }));
    draw(buffer, "b");
    expect(buffer.ready(0.7)).toBe(false);
    draw(buffer, "a");
    expect(buffer.ready(0.7)).toBe(true);
  });

  it("is not complete while the scene grows, and asks for what is added", () => {
    const growing = manifest({ slices: slices.slice(0, 1), live: 1 });
    const buffer = new SceneBuffer(growing);
    draw(buffer, "a");
    expect(buffer.complete).toBe(false);
    Object.assign(growing, { slices: slices.slice(0, 2), live: null });
    buffer.grow();
    expect([buffer.complete, buffer.playable(0.7)]).toEqual([false, false]);
    draw(buffer, "b");
    expect([buffer.complete, buffer.playable(0.7)]).toEqual([true, true]);
  });

  it("joins neighbouring slices to one range", () => {
    const buffer = new SceneBuffer(manifest({ slices }));
    expect(buffer.ranges()).toEqual([]);
    draw(buffer, "a");
    expect(buffer.ranges()).toEqual([[0, 0.5]]);
    draw(buffer, "b");
    expect(buffer.ranges()).toEqual([[0, 1]]);
  });

  it("keeps ranges apart where something is missing between", () => {
    const buffer = new SceneBuffer(manifest({ slices }));
    for (const id of ["a", "c", "d"]) draw(buffer, id);
    expect(buffer.ranges()).toEqual([
      [0, 0.5],
      [1, 2],
    ]);
  });

  it("is complete once every chunk is here, counting one that several slices name once", () => {
    const shared = [slice(0, 1, ["a"]), slice(1, 2, ["a", "b"])];
    const buffer = new SceneBuffer(manifest({ static: [entry("s")], slices: shared }));
    for (const id of ["a", "b"]) draw(buffer, id);
    expect(buffer.complete).toBe(false);
    draw(buffer, "s");
    expect(buffer.complete).toBe(true);
  });

  it("shows what there is at the time of a chunk that cannot be had", () => {
    const buffer = new SceneBuffer(manifest({ slices, static: [entry("s"), entry("t")] }));
    for (const id of ["c", "t"]) draw(buffer, id);
    for (const id of ["d", "s", "t"]) buffer.states.lose(id);
    expect(buffer.ready(1.5)).toBe(true);
    expect(buffer.ranges()).toEqual([[1, 2]]);
    expect(buffer.staticComplete).toBe(true);
    expect(buffer.states.lost).toBe(2);
    draw(buffer, "d"); // it has been mended
    expect(buffer.states.lost).toBe(1);
  });

  it("can be played once the base layers are here", () => {
    const layered = manifest({ slices: [slice(0, 2, ["a", "b", "c"])], static: ["s", "t"].map((id) => entry(id)) });
    const buffer = new SceneBuffer(layered);
    draw(buffer, "a");
    expect(buffer.playable(1)).toBe(false);
    draw(buffer, "s");
    expect(buffer.playable(1)).toBe(true);
    expect(buffer.ready(1)).toBe(false);
    expect(buffer.ranges()).toEqual([[0, 2]]);
  });

  describe("while it waits", () => {
    const seconds = Array.from({ length: 20 }, (_, k) => slice(k, k + 1, [`a${k}`, `b${k}`]));
    const buffer = new SceneBuffer(manifest({ end: 20, slices: seconds })); // a base of 100 bytes per second

    it("goes on where the line brings base layers as fast as they are shown", () => {
      expect(buffer.lasts(0, 1, 1e6, 1.5)).toBe(false); // nothing is here
      draw(buffer, "a0");
      expect(buffer.lasts(0, 1, 130, 1.5)).toBe(true);
      expect(buffer.lasts(0, 2, 130, 1.5)).toBe(false);
      expect(buffer.lasts(0, 1, 90, 1.5)).toBe(false);
    });

    it("goes on when there is enough for a while", () => {
      draw(buffer, "a1");
      expect(buffer.lasts(0, 1, 0, 1.5)).toBe(true);
      expect(buffer.lasts(0.6, 1, 0, 1.5)).toBe(false);
      expect(buffer.lasts(0, 1, 0, 4)).toBe(false);
    });

    it("goes on when nothing is missing any more", () => {
      draw(buffer, "a19");
      expect(buffer.lasts(19.5, 1, 0, 1.5)).toBe(true);
    });
  });

  it("is always ready in a still scene", () => {
    const buffer = new SceneBuffer(manifest({ static: [entry("s")] }));
    expect(buffer.ready(1)).toBe(true);
    expect(buffer.ranges()).toEqual([[0, 2]]);
    expect(buffer.staticComplete).toBe(false);
    draw(buffer, "s");
    expect(buffer.staticComplete).toBe(true);
  });
});
