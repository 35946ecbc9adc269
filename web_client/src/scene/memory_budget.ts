/** How much of a scene is kept in memory. */

import { chunksOf } from "../codec/manifest_chunks";
import type { Manifest, Room } from "../codec/types";
import { rowsOf, TEXTURE_WIDTH } from "../renderer/layout";

const MB = 1 << 20;
/** What waits for its time, and what is on its way from the decoder to the textures: about so many bytes. */
const UNDER_WAY = 40 * MB;
/** Bytes of a texture's row: RGBA32F. */
const ROW = 16 * TEXTURE_WIDTH;
/** Bytes of a row of dynamics in all: two textures, motion, lives and reaches at the worker, and the chunk's compressed bytes. */
const DYNAMIC_ROW = ROW + ROW / 4 + 256 * (18 + 4) * 4 + 256 * 24;
/** Of a row of statics: the texture, positions at the worker, and the chunk's compressed bytes. */
const STATIC_ROW = ROW + 512 * (3 * 4 + 16);

/** A scene that grows is taken to become so many times as large; what does not fit then comes and goes. */
const GROWTH = 4;

/** What a browser tells of its device. */
export interface Device {
  /** GiB, at most 8; not told by every browser. */
  readonly deviceMemory?: number;
  readonly userAgent?: string;
}

/** Bytes for a scene's splats on a device. */
export function defaultBudget(device: Device = globalThis.navigator ?? {}): number {
  const phone = /Android|iPhone|iPad|Mobile/.test(device.userAgent ?? "") || (device.deviceMemory ?? 8) <= 4;
  return (phone ? 192 : 384) * MB;
}

/**
 * How many rows of dynamics a budget, in bytes, has room for beside the statics: at most all of the scene, and at least
 * what any one moment needs, even if that is more than the budget.
 */
export function dynamicRows(manifest: Manifest, staticRows: number, budget: number, most: number): number {
  const { slices, room } = manifest;
  const sizes = new Map(slices.flatMap(({ chunks }) => chunks.map((chunk) => [chunk.id, rowsOf(chunk)] as const)));
  const sum = (ids: Iterable<string>) => [...ids].reduce((rows, id) => rows + (sizes.get(id) ?? 0), 0);
  const enough = (of: Room) => of.chunks + rowsOf(of); // each chunk takes whole rows
  const all = (room ? enough(room.all) : sum(sizes.keys())) * (manifest.live === null ? 1 : GROWTH);
  const affordable = Math.min(most, Math.floor((budget - UNDER_WAY - staticRows * STATIC_ROW) / DYNAMIC_ROW));
  // Of two slices in a row: while one is shown, the other comes.
  const needed = slices.map((slice, i) =>
    sum(new Set([...chunksOf(slice), ...chunksOf(slices[(i + 1) % slices.length])])),
  );
  return Math.min(all, Math.max(affordable, room ? enough(room.most) : 0, ...needed));
}
