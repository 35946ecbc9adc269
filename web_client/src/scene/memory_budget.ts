/** The memory budget of a scene. */

import { chunksOf } from "../codec/manifest_chunks";
import type { Manifest, Room } from "../codec/types";
import { rowsOf, TEXTURE_WIDTH } from "../renderer/layout";

const MB = 1 << 20;
/** Bytes of waiting chunks, and of data between decoder and textures, about. */
const UNDER_WAY = 40 * MB;
/** Bytes of a texture's row: RGBA32F. */
const ROW = 16 * TEXTURE_WIDTH;
/**
 * Total bytes of a row of dynamics: two textures, motion, lives and reaches at the worker, and the chunk's compressed
 * bytes.
 */
const DYNAMIC_ROW = ROW + ROW / 4 + 256 * (18 + 4) * 4 + 256 * 24;
/** Total bytes of a row of statics: the texture, positions at the worker, and the chunk's compressed bytes. */
const STATIC_ROW = ROW + 512 * (3 * 4 + 16);

/** Assumed growth of a growing scene, a factor; beyond it, chunks are evicted. */
const GROWTH = 4;

/** A browser's description of its device. */
export interface Device {
  /** GiB, at most 8; not in every browser. */
  readonly deviceMemory?: number;
  readonly userAgent?: string;
}

/** Bytes for a scene's splats on a device. */
export function defaultBudget(device: Device = globalThis.navigator ?? {}): number {
  const phone = /Android|iPhone|iPad|Mobile/.test(device.userAgent ?? "") || (device.deviceMemory ?? 8) <= 4;
  return (phone ? 192 : 384) * MB;
}

/**
 * Number of rows of dynamics that a budget, in bytes, allows beside the statics: at most the whole scene, and at least
 * the needs of any one moment, even beyond the budget.
 */
export function dynamicRows(manifest: Manifest, staticRows: number, budget: number, most: number): number {
  const { slices, room } = manifest;
  const sizes = new Map(slices.flatMap(({ chunks }) => chunks.map((chunk) => [chunk.id, rowsOf(chunk)] as const)));
  const sum = (ids: Iterable<string>) => [...ids].reduce((rows, id) => rows + (sizes.get(id) ?? 0), 0);
  const enough = (of: Room) => of.chunks + rowsOf(of); // each chunk takes whole rows
  const all = (room ? enough(room.all) : sum(sizes.keys())) * (manifest.live === null ? 1 : GROWTH);
  const affordable = Math.min(most, Math.floor((budget - UNDER_WAY - staticRows * STATIC_ROW) / DYNAMIC_ROW));
  // Two consecutive slices: while one is shown, the next one arrives.
  const needed = slices.map((slice, i) =>
    sum(new Set([...chunksOf(slice), ...chunksOf(slices[(i + 1) % slices.length])])),
  );
  return Math.min(all, Math.max(affordable, room ? enough(room.most) : 0, ...needed));
}
