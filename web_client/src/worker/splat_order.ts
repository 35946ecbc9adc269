/**
 * Which splats are drawn, and in which order: the statics before the camera, and the dynamics alive at the time, where
 * they have moved to by then.
 */

import { chunksOf, sliceAt } from "../codec/slices";
import type { DecodedChunk, Manifest, StaticChunk } from "../codec/types";
import { DYNAMIC_BIT, TEXTURE_WIDTH } from "../renderer/layout";
import { type PlanarDepth, type RadialDepth, type SplatDepth, sameDepth } from "./depth";
import type { Placement } from "./placement";
import { mergeBackToFront, RadixSorter, type SortedSplats } from "./sort";

export interface SplatOrder {
  /** Ids, farthest first, in whole rows of the order texture. */
  readonly ids: Uint32Array<ArrayBuffer>;
  readonly count: number;
  /** Living dynamic splats among them. */
  readonly dynamic: number;
  /** The segment's time at which the dynamics are to be drawn. */
  readonly normalisedTime: number;
}

interface Statics {
  readonly first: number;
  readonly means: Float32Array;
}

interface Dynamics {
  readonly count: number;
  readonly first: number;
  readonly motion: Float32Array;
  readonly centers: Float32Array;
  /** ln(255 sigma) / s: the square of how far from its centre in time a splat can be seen. */
  readonly reach: Float32Array;
}

/** A list of (depth, id) that grows and sorts itself. */
class DepthList implements SortedSplats {
  count = 0;
  keys = new Uint32Array(0);
  ids = new Uint32Array(0);
  depths = new Float32Array(0);

  reset(capacity: number): void {
    this.count = 0;
    if (this.keys.length >= capacity) return;
    this.keys = new Uint32Array(Math.ceil(capacity * 1.25));
    this.ids = new Uint32Array(this.keys.length);
    this.depths = new Float32Array(this.keys.buffer);
  }
}

export class SplatOrderer {
  readonly #sorter = new RadixSorter();
  readonly #statics: Statics[] = []; // by id
  readonly #dynamics = new Map<string, Dynamics>();
  readonly #staticList = new DepthList();
  readonly #dynamicList = new DepthList();
  #sortedBy: SplatDepth | null = null; // of the static list; null when it is out of date

  constructor(
    readonly manifest: Manifest,
    readonly placement: Placement,
  ) {}

  add(id: string, chunk: DecodedChunk): void {
    const first = this.placement.first.get(id);
    if (first === undefined) return;
    if (chunk.kind === "static") {
      this.#addStatics(first, chunk);
      return;
    }
    const reach = new Float32Array(chunk.count);
    for (let i = 0; i < chunk.count; i++) {
      reach[i] = Math.log(255 * chunk.opacities[i]) / Math.exp(chunk.timeLogPrecisions[i]);
    }
    const { count, motion, timeCenters: centers } = chunk;
    this.#dynamics.set(id, { count, first, motion, centers, reach });
  }

  /** Order what is seen at `time` (seconds). `recycled` is an earlier array of ids that may be written again. */
  order(depth: SplatDepth, time: number, recycled?: Uint32Array<ArrayBuffer>): SplatOrder {
    this.#sortStatics(depth);
    const normalisedTime = this.#sortDynamics(depth, time);
    const count = this.#staticList.count + this.#dynamicList.count;
    const length = Math.ceil(count / TEXTURE_WIDTH) * TEXTURE_WIDTH;
    const ids = recycled && recycled.length >= length ? recycled : new Uint32Array(length);
    mergeBackToFront(this.#staticList, this.#dynamicList, ids);
    return { ids, count, dynamic: this.#dynamicList.count, normalisedTime };
  }

  #addStatics(first: number, chunk: StaticChunk): void {
    this.#statics.push({ first, means: chunk.means });
    this.#statics.sort((a, b) => a.first - b.first);
    this.#sortedBy = null;
  }

  #sortStatics(depth: SplatDepth): void {
    const last = this.#sortedBy;
    if (last && sameDepth(last, depth)) return;
    this.#sortedBy = depth;
    const list = this.#staticList;
    list.reset(this.#statics.reduce((sum, { means }) => sum + means.length / 3, 0));
    if (depth.kind === "planar") this.#planarStatics(depth);
    else this.#radialStatics(depth);
    this.#sorter.sort(list.keys, list.ids, list.count);
  }

  #planarStatics({ x, y, z, offset, near }: PlanarDepth): void {
    const list = this.#staticList;
    const { depths, ids } = list;
    let n = 0;
    for (const { first, means } of this.#statics) {
      for (let i = 0, at = 0; at < means.length; i++, at += 3) {
        const depth = x * means[at] + y * means[at + 1] + z * means[at + 2] + offset;
        if (!(depth >= near)) continue;
        depths[n] = depth;
        ids[n++] = first + i;
      }
    }
    list.count = n;
  }

  /** By the square of the distance, which grows as it does. */
  #radialStatics({ x, y, z, near }: RadialDepth): void {
    const list = this.#staticList;
    const { depths, ids } = list;
    const nearest = near * near;
    let n = 0;
    for (const { first, means } of this.#statics) {
      for (let i = 0, at = 0; at < means.length; i++, at += 3) {
        const dx = means[at] - x;
        const dy = means[at + 1] - y;
        const dz = means[at + 2] - z;
        const square = dx * dx + dy * dy + dz * dz;
        if (!(square >= nearest)) continue;
        depths[n] = square;
        ids[n++] = first + i;
      }
    }
    list.count = n;
  }

  /** Returns the normalised time. */
  #sortDynamics(by: SplatDepth, time: number): number {
    const list = this.#dynamicList;
    const slice = this.manifest.slices[sliceAt(this.manifest.slices, time)];
    const segment = slice && this.manifest.segments[slice.segment];
    if (!slice || !segment) {
      list.count = 0;
      return 0;
    }
    const duration = segment.end - segment.start;
    const t = duration > 0 ? (time - segment.start) / duration : 0;
    const chunks = chunksOf(slice)
      .flatMap((id) => this.#dynamics.get(id) ?? [])
      .sort((a, b) => a.first - b.first);
    list.reset(chunks.reduce((sum, chunk) => sum + chunk.count, 0));
    const { depths, ids } = list;
    const planar = by.kind === "planar";
    const offset = planar ? by.offset : 0;
    const nearest = planar ? by.near : by.near * by.near;
    let n = 0;
    for (const { count, first, motion, centers, reach } of chunks) {
      const width = motion.length / count;
      const fifth = width > 12;
      for (let i = 0; i < count; i++) {
        const d = t - centers[i];
        if (!(d * d <= reach[i])) continue;
        const m = width * i;
        let cx = motion[m + 9];
        let cy = motion[m + 10];
        let cz = motion[m + 11];
        if (fifth) {
          cx += d * (motion[m + 12] + d * motion[m + 15]);
          cy += d * (motion[m + 13] + d * motion[m + 16]);
          cz += d * (motion[m + 14] + d * motion[m + 17]);
        }
        const x = motion[m] + d * (motion[m + 3] + d * (motion[m + 6] + d * cx));
        const y = motion[m + 1] + d * (motion[m + 4] + d * (motion[m + 7] + d * cy));
        const z = motion[m + 2] + d * (motion[m + 5] + d * (motion[m + 8] + d * cz));
        const depth = planar
          ? by.x * x + by.y * y + by.z * z + offset
          : (x - by.x) * (x - by.x) + (y - by.y) * (y - by.y) + (z - by.z) * (z - by.z);
        if (!(depth >= nearest)) continue;
        depths[n] = depth;
        ids[n++] = (DYNAMIC_BIT | (first + i)) >>> 0;
      }
    }
    list.count = n;
    this.#sorter.sort(list.keys, ids, n);
    return t;
  }
}
