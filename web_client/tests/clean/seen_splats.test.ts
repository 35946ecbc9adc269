import { describe, expect, it } from "vitest";
import { boxArea } from "../../src/clean/areas";
import { markedTexels } from "../../src/clean/marked_texels";
import { type ChunkSplats, seenSplats } from "../../src/clean/seen_splats";
import { DELETED, HIDDEN, SELECTED } from "../../src/clean/splat_marks";
import type { DynamicChunk, StaticChunk } from "../../src/codec/types";
import type { Shot } from "../../src/renderer/shot";
import { packDynamics, packFifth, packStatics } from "../../src/worker/pack";

const CAMERA = { width: 200, height: 100, fx: 100, fy: 100, cx: 100, cy: 50, near: 0.1 };
const SHOT: Shot = {
  pose: { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [0, 0, 0] },
  camera: CAMERA,
  time: 0.5,
  antialiased: false,
  rig: [],
};
const ALL = boxArea([0, 0], [200, 100]);

interface Still {
  readonly at: readonly [number, number, number];
  readonly size?: number;
  readonly opacity?: number;
}

function statics(id: string, splats: readonly Still[]): ChunkSplats {
  const chunk = {
    count: splats.length,
    means: Float32Array.from(splats.flatMap(({ at }) => at)),
    quats: Float32Array.from(splats.flatMap(() => [1, 0, 0, 0])),
    logScales: Float32Array.from(splats.flatMap(({ size = 0.2 }) => [size, size, size].map(Math.log))),
    opacities: Float32Array.from(splats, ({ opacity = 0.99 }) => opacity),
    rgb: new Float32Array(3 * splats.length),
  } as unknown as StaticChunk;
  return { id, kind: "static", count: splats.length, texels: packStatics(chunk), fifth: new Float32Array(0) };
}

/** A splat that flies from the left to the right, seen for a tenth of the segment around `center`; `fifth` pushes it. */
function flying(center: number, fifth = 0): ChunkSplats {
  const motion = new Float32Array(18);
  motion.set([0, 0, 2, 4, 0, 0]);
  motion[15] = fifth;
  const chunk = {
    count: 1,
    motion,
    rotation: Float32Array.from([1, 0, 0, 0, 0, 0, 0, 0]),
    logScales: new Float32Array(3).fill(Math.log(0.1)),
    opacities: Float32Array.from([0.9]),
    rgb: new Float32Array(3),
    timeCenters: Float32Array.from([center]),
    timeLogPrecisions: Float32Array.from([Math.log(500)]),
  } as unknown as DynamicChunk;
  return { id: "flying", kind: "dynamic", count: 1, texels: packDynamics(chunk), fifth: packFifth(chunk) };
}

const seen = (chunks: readonly ChunkSplats[], area = ALL, through = false, marks?: Uint8Array) =>
  Object.fromEntries(seenSplats(chunks, SHOT, CAMERA, area, () => marks, through));

describe("seen splats", () => {
  const wall: Still[] = [0, 1, 2].map((depth) => ({ at: [0, 0, 2 + 0.1 * depth], size: 0.5 }));

  it("are those that nothing hides", () => {
    const chunks = [
      statics("a", [{ at: [0, 0, 6], size: 0.1 }, ...wall]),
      statics("b", [{ at: [0.4, 0, 1], size: 0.05 }]),
    ];
    const { a, b } = seen(chunks);
    expect(b).toEqual([0]);
    expect(a).toContain(1);
    expect(a).not.toContain(0);
  });

  it("are all of them on request", () => {
    expect(seen([statics("a", [{ at: [0, 0, 6] }, ...wall])], ALL, true).a).toEqual([0, 1, 2, 3]);
  });

  it("are seen through what is faint", () => {
    const haze: Still[] = [{ at: [0, 0, 1], size: 0.3, opacity: 0.2 }];
    expect(seen([statics("a", [...haze, { at: [0, 0, 6] }])]).a).toEqual([0, 1]);
  });

  it("have their centres in the area and before the camera", () => {
    const chunk = statics("a", [{ at: [0.5, 0, 2] }, { at: [-0.5, 0, 2] }, { at: [0, 0, -2] }, { at: [0.5, 0, 0.05] }]);
    expect(seen([chunk], boxArea([100, 0], [200, 100])).a).toEqual([0]);
  });

  it("move: the place at the time counts, and the life", () => {
    const right = boxArea([110, 0], [200, 100]);
    expect(seen([flying(0.45)], right).flying).toEqual([0]); // x = 4 * 0.05 at depth 2: pixel 110
    expect(seen([flying(0.55)], right).flying).toBeUndefined();
    expect(seen([flying(0.1)]).flying).toBeUndefined(); // gone at 0.5
    expect(seen([flying(0.45, -1e6)], right).flying).toBeUndefined(); // the fifth order takes it away
  });

  it("neither count nor hide once they are hidden or deleted", () => {
    const chunk = statics("a", [{ at: [0, 0, 1] }, { at: [0, 0, 2] }, { at: [0, 0, 4] }]);
    expect(seen([chunk], ALL, false, Uint8Array.of(DELETED, HIDDEN, SELECTED)).a).toEqual([2]);
  });

  it("of subject-only views are none that stand still", () => {
    const found = seenSplats([statics("a", wall)], { ...SHOT, still: 0 }, CAMERA, ALL, () => undefined, false);
    expect(found.size).toBe(0);
  });
});

describe("marked texels", () => {
  it("are tinted or invisible, and others as they were", () => {
    const chunk = statics("a", [{ at: [0, 0, 1] }, { at: [0, 0, 2] }, { at: [0, 0, 3] }]);
    const marked = markedTexels(chunk, Uint8Array.of(0, SELECTED, SELECTED | DELETED));
    expect(marked.subarray(0, 16)).toEqual(chunk.texels.subarray(0, 16));
    expect(marked[16 + 12]).toBeGreaterThan(0.5);
    expect(marked[16 + 3]).toBe(chunk.texels[16 + 3]);
    expect(marked[32 + 3]).toBe(0);
    expect(chunk.texels[32 + 3]).toBeGreaterThan(0.9);
  });

  it("of moving splats have their colour and opacity elsewhere", () => {
    const chunk = flying(0.5);
    expect(markedTexels(chunk, Uint8Array.of(HIDDEN))[23]).toBe(0);
    expect(markedTexels(chunk, Uint8Array.of(SELECTED))[24]).toBeGreaterThan(0.5);
  });
});
