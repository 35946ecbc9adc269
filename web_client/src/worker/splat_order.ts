/**
 * The order of drawing: the statics before the camera, and the dynamics alive at the time, at their positions then;
 * without splats outside the picture.
 */

import { chunksOf, sliceAt } from "../codec/manifest_chunks";
import type { DecodedChunk, Manifest } from "../codec/types";
import { isDynamic, type StaticPlacement, TEXTURE_WIDTH } from "../renderer/layout";
import { BLOCK, StaticBlocks } from "./blocks";
import { type SplatDepth, sameDepth } from "./depth";
import { Dynamics } from "./dynamics";
import { type Frustum, sameFrustum } from "./frustum";
import { DepthList, mergeBackToFront } from "./sort";
import { SplatBudget } from "./splat_budget";

/** A request for an order; times in seconds, of one segment. */
export interface OrderRequest {
  readonly depth: SplatDepth;
  /** Only splats inside are ordered; all of them if null. */
  readonly frustum: Frustum | null;
  /** Whether the order must be exact; a faster one may treat nearly equal depths as equal. */
  readonly exact: boolean;
  /** Largest number of splats, the most useful ones; `Infinity` for all. */
  readonly budget: number;
  /** Dynamics are sorted by their positions at this moment. */
  readonly time: number;
  /** All dynamics alive at any moment from `from` until `until` are included; `time` lies between. */
  readonly from: number;
  readonly until: number;
}

export interface SplatOrder {
  /** Ids, farthest first, in whole rows of the order texture. */
  readonly ids: Uint32Array<ArrayBuffer>;
  readonly count: number;
  /** Number of dynamic splats among them. */
  readonly dynamic: number;
}

interface Living {
  readonly chunks: readonly Dynamics[];
  readonly span: readonly [time: number, from: number, until: number];
}

export class SplatOrderer {
  readonly #statics: StaticBlocks[] = []; // blocks by chunk id
  readonly #dynamics = new Map<string, Dynamics>();
  readonly #staticList = new DepthList();
  readonly #dynamicList = new DepthList();
  readonly #budget: SplatBudget;
  #sortedFor: Pick<OrderRequest, "depth" | "frustum"> | null = null; // key of the static list, or null
  #ranks: ReadonlyMap<string, number> = new Map(); // ranks of dynamic chunks in the manifest, to break ties

  constructor(
    public manifest: Manifest,
    readonly placement: StaticPlacement,
  ) {
    this.#budget = new SplatBudget(placement.rows);
    this.grow(manifest);
  }

  /** Continue with a later version of the manifest; its statics are the same. */
  grow(manifest: Manifest): void {
    this.manifest = manifest;
    this.#ranks = new Map(manifest.slices.flatMap(({ chunks }) => chunks).map(({ id }, rank) => [id, rank]));
  }

  /**
   * Add a decoded chunk.
   *
   * @param rows of the texture for the splats of a dynamic chunk.
   */
  add(id: string, chunk: DecodedChunk, rows: readonly number[] = []): void {
    if (chunk.kind === "dynamic") {
      this.#dynamics.set(id, new Dynamics(rows, chunk));
      return;
    }
    const first = this.placement.first.get(id);
    if (first === undefined) return;
    this.#statics.push(new StaticBlocks(first, chunk));
    this.#budget.addStatics(first, chunk.count, chunk.bounds);
    this.#statics.sort((a, b) => a.first - b.first);
    this.#sortedFor = null;
  }

  /** Forget a dynamic chunk. */
  evict(id: string): void {
    this.#dynamics.delete(id);
  }

  /** Order the splats; `recycled` is an earlier array of ids to be overwritten. */
  order(request: OrderRequest, recycled?: Uint32Array<ArrayBuffer>): SplatOrder {
    const order = request.exact ? this.#exactly(request, recycled) : this.#quickly(request, recycled);
    return order.count > request.budget ? this.#cut(order, request) : order;
  }

  /** The part of an order within its budget. */
  #cut({ ids, count }: SplatOrder, request: OrderRequest): SplatOrder {
    const { chunks, span } = this.#living(request);
    const levels = this.#budget.levels(Math.max(0, ...chunks.map(({ end }) => end)));
    for (const chunk of chunks) chunk.writeLevels(levels, span[0]);
    const kept = this.#budget.cut(ids, count, request.budget);
    let dynamic = 0;
    for (let i = 0; i < kept; i++) if (isDynamic(ids[i])) dynamic++;
    return { ids, count: kept, dynamic };
  }

  /** The order for a view that rests: only the dynamics are sorted again. */
  #exactly(request: OrderRequest, recycled?: Uint32Array<ArrayBuffer>): SplatOrder {
    this.#sortStatics(request);
    const [statics, dynamics] = [this.#staticList, this.#dynamicList];
    dynamics.reset(0);
    this.#addDynamics(request, dynamics);
    dynamics.sort();
    const count = statics.count + dynamics.count;
    const ids = rowsFor(count, recycled);
    mergeBackToFront(statics, dynamics, ids);
    return { ids, count, dynamic: dynamics.count };
  }

  /** The order for a view that moves: everything is sorted again. */
  #quickly(request: OrderRequest, recycled?: Uint32Array<ArrayBuffer>): SplatOrder {
    this.#sortedFor = null;
    const list = this.#staticList;
    this.#addStatics(request, list);
    const statics = list.count;
    this.#addDynamics(request, list);
    const ids = rowsFor(list.count, recycled);
    list.writeQuickly(ids);
    return { ids, count: list.count, dynamic: list.count - statics };
  }

  #sortStatics(request: OrderRequest): void {
    const last = this.#sortedFor;
    const { depth, frustum } = request;
    if (last && sameDepth(last.depth, depth) && sameFrustum(last.frustum, frustum)) return;
    this.#sortedFor = { depth, frustum };
    this.#addStatics(request, this.#staticList);
    this.#staticList.sort();
  }

  /** Fill a list with the statics. */
  #addStatics({ depth, frustum }: OrderRequest, list: DepthList): void {
    list.reset(this.#statics.reduce((sum, { count }) => sum + count, 0));
    for (const blocks of this.#statics) {
      for (let begin = 0; begin < blocks.count; begin += BLOCK) {
        if (!blocks.mayShow(begin, depth, frustum)) continue;
        const end = Math.min(blocks.count, begin + BLOCK);
        if (depth.kind === "planar") addPlanar(list, blocks, begin, end, depth);
        else addRadial(list, blocks, begin, end, depth);
      }
    }
  }

  /** Add the living dynamics to a list. */
  #addDynamics(request: OrderRequest, list: DepthList): void {
    const { chunks, span } = this.#living(request);
    list.makeRoom(chunks.reduce((sum, chunk) => sum + chunk.count, 0));
    for (const chunk of chunks) chunk.addTo(list, request.depth, request.frustum, ...span);
  }

  /** The chunks with dynamics alive from `from` until `until`; and `time`, `from` and `until`, normalised. */
  #living({ time, from, until }: OrderRequest): Living {
    const { slices, segments } = this.manifest;
    const { segment } = slices[sliceAt(slices, time)] ?? {};
    if (segment === undefined) return { chunks: [], span: [0, 0, 0] };
    const { start, end } = segments[segment];
    const normalised = (moment: number) => (end > start ? (moment - start) / (end - start) : 0);
    const span = [normalised(time), normalised(from), normalised(until)] as const;
    return { chunks: this.#chunksBetween(segment, from, until), span };
  }

  /** The chunks of a segment with splats alive from `from` until `until`, seconds, in the manifest's order. */
  #chunksBetween(segment: number, from: number, until: number): Dynamics[] {
    const { slices } = this.manifest;
    const ids = new Set<string>();
    for (let i = sliceAt(slices, from); i <= sliceAt(slices, until); i++) {
      if (slices[i].segment === segment) for (const id of chunksOf(slices[i])) ids.add(id);
    }
    const ranked = [...ids].sort((a, b) => (this.#ranks.get(a) ?? 0) - (this.#ranks.get(b) ?? 0));
    return ranked.flatMap((id) => this.#dynamics.get(id) ?? []);
  }
}

/** An array of whole rows of the order texture. */
function rowsFor(count: number, recycled?: Uint32Array<ArrayBuffer>): Uint32Array<ArrayBuffer> {
  const length = Math.ceil(count / TEXTURE_WIDTH) * TEXTURE_WIDTH;
  return recycled && recycled.length >= length ? recycled : new Uint32Array(length);
}

type Of<Kind> = Extract<SplatDepth, { kind: Kind }>;

function addPlanar(
  list: DepthList,
  { first, means }: StaticBlocks,
  begin: number,
  end: number,
  by: Of<"planar">,
): void {
  const { depths, ids } = list;
  const { x, y, z, offset, near } = by;
  let n = list.count;
  for (let i = begin, at = 3 * begin; i < end; i++, at += 3) {
    const depth = x * means[at] + y * means[at + 1] + z * means[at + 2] + offset;
    if (!(depth >= near)) continue;
    depths[n] = depth;
    ids[n++] = first + i;
  }
  list.count = n;
}

/** Add splats by the square of their distance, which has the same order. */
function addRadial(
  list: DepthList,
  { first, means }: StaticBlocks,
  begin: number,
  end: number,
  by: Of<"radial">,
): void {
  const { depths, ids } = list;
  const { x, y, z } = by;
  const nearest = by.near * by.near;
  let n = list.count;
  for (let i = begin, at = 3 * begin; i < end; i++, at += 3) {
    const dx = means[at] - x;
    const dy = means[at + 1] - y;
    const dz = means[at + 2] - z;
    const square = dx * dx + dy * dy + dz * dz;
    if (!(square >= nearest)) continue;
    depths[n] = square;
    ids[n++] = first + i;
  }
  list.count = n;
}
