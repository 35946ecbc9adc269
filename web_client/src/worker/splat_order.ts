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

/** What is to be ordered; times in seconds, of one segment. */
export interface OrderRequest {
  readonly depth: SplatDepth;
  /** Dynamics are sorted where they are at this moment. */
  readonly time: number;
  /** All dynamics are in the order that are alive at any moment from `from` until `until`; `time` lies between. */
  readonly from: number;
  readonly until: number;
}

export interface SplatOrder {
  /** Ids, farthest first, in whole rows of the order texture. */
  readonly ids: Uint32Array<ArrayBuffer>;
  readonly count: number;
  /** Living dynamic splats among them. */
  readonly dynamic: number;
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

  /** `recycled` is an earlier array of ids that may be written again. */
  order(request: OrderRequest, recycled?: Uint32Array<ArrayBuffer>): SplatOrder {
    this.#sortStatics(request.depth);
    this.#sortDynamics(request);
    const count = this.#staticList.count + this.#dynamicList.count;
    const length = Math.ceil(count / TEXTURE_WIDTH) * TEXTURE_WIDTH;
    const ids = recycled && recycled.length >= length ? recycled : new Uint32Array(length);
    mergeBackToFront(this.#staticList, this.#dynamicList, ids);
    return { ids, count, dynamic: this.#dynamicList.count };
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

  #sortDynamics({ depth: by, time, from, until }: OrderRequest): void {
    const list = this.#dynamicList;
    list.count = 0;
    const { slices, segments } = this.manifest;
    const { segment } = slices[sliceAt(slices, time)] ?? {};
    if (segment === undefined) return;
    const { start, end } = segments[segment];
    const normalised = (moment: number) => (end > start ? (moment - start) / (end - start) : 0);
    const t = normalised(time);
    const [first, last] = [normalised(from), normalised(until)];
    const chunks = this.#chunksBetween(segment, from, until);
    list.reset(chunks.reduce((sum, chunk) => sum + chunk.count, 0));
    const { depths, ids } = list;
    const planar = by.kind === "planar";
    const offset = planar ? by.offset : 0;
    const nearest = planar ? by.near : by.near * by.near;
    let n = 0;
    for (const { count, first: id, motion, centers, reach } of chunks) {
      const width = motion.length / count;
      const fifth = width > 12;
      for (let i = 0; i < count; i++) {
        const center = centers[i];
        const outside = center < first ? first - center : center > last ? center - last : 0;
        if (!(outside * outside <= reach[i])) continue;
        const d = t - center;
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
        ids[n++] = (DYNAMIC_BIT | (id + i)) >>> 0;
      }
    }
    list.count = n;
    this.#sorter.sort(list.keys, ids, n);
  }

  /** Those of a segment with splats alive from `from` until `until`, seconds, in order of their ids. */
  #chunksBetween(segment: number, from: number, until: number): Dynamics[] {
    const { slices } = this.manifest;
    const ids = new Set<string>();
    for (let i = sliceAt(slices, from); i <= sliceAt(slices, until); i++) {
      if (slices[i].segment === segment) for (const id of chunksOf(slices[i])) ids.add(id);
    }
    return [...ids].flatMap((id) => this.#dynamics.get(id) ?? []).sort((a, b) => a.first - b.first);
  }
}
