/** Small manifests and chunks for tests. */

import type { Bounds, Box, ChunkEntry, DynamicChunk, Manifest, SliceEntry, StaticChunk } from "../src/codec/types";
import type { SceneBuffer } from "../src/scene/buffer";

const bounds: Bounds = { position: 0, blur: 0, shape: 0, opacity: 0, rgb: 0 };
const box: Box = { min: [-1, -1, -1], max: [1, 1, 1] };

export const entry = (id: string, splats = 1): ChunkEntry => ({ id, bytes: 100, splats, box });

export const slice = (start: number, end: number, ids: string[], needs: string[] = [], segment = 0): SliceEntry => ({
  segment,
  start,
  end,
  chunks: ids.map((id) => entry(id)),
  needs,
});

export const manifest = (fields: Partial<Manifest> = {}): Manifest => ({
  version: 2,
  title: "test",
  start: 0,
  end: 2,
  frameRate: 30,
  background: [0, 0, 0],
  up: [0, -1, 0],
  center: [0, 0, 0],
  extent: 3,
  cameras: [],
  segments: [{ start: 0, end: 2 }],
  static: [],
  slices: [],
  totals: { splatsStatic: 0, splatsDynamic: 0, bytesStatic: 0, bytesDynamic: 0 },
  thumbnail: false,
  training: {},
  antialiased: false,
  metresPerUnit: null,
  live: null,
  startViews: [],
  photographed: false,
  capturedSpace: null,
  ...fields,
});

/** Make a chunk drawn. */
export function draw(buffer: SceneBuffer, id: string): void {
  buffer.states.set(id, { at: "drawn", rows: [] });
}

export function staticChunk(means: number[]): StaticChunk {
  const count = means.length / 3;
  return {
    kind: "static",
    count,
    timeRange: [0, 0],
    box,
    bounds,
    means: Float32Array.from(means),
    quats: Float32Array.from({ length: 4 * count }, (_, i) => (i % 4 === 0 ? 1 : 0)),
    logScales: new Float32Array(3 * count).fill(-2),
    opacities: new Float32Array(count).fill(0.5),
    rgb: new Float32Array(3 * count).fill(0.25),
  };
}

/** Dynamic splats that start at z = `depths` at their centre in time and move along z with `speeds`; maybe by d^5, too. */
export function dynamicChunk(
  depths: number[],
  speeds: number[],
  centers: number[],
  logPrecision: number,
  fifth?: number[],
): DynamicChunk {
  const count = depths.length;
  const width = fifth ? 18 : 12;
  const motion = new Float32Array(width * count);
  const rotation = new Float32Array(8 * count);
  for (let i = 0; i < count; i++) {
    motion[width * i + 2] = depths[i];
    motion[width * i + 5] = speeds[i];
    if (fifth) motion[width * i + 17] = fifth[i];
    rotation[8 * i] = 1;
  }
  return {
    kind: "dynamic",
    count,
    timeRange: [0, 2],
    box,
    bounds,
    motion,
    rotation,
    logScales: new Float32Array(3 * count).fill(-2),
    opacities: new Float32Array(count).fill(0.5),
    rgb: new Float32Array(3 * count).fill(0.25),
    timeCenters: Float32Array.from(centers),
    timeLogPrecisions: new Float32Array(count).fill(logPrecision),
  };
}
