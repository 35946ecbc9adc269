/** The current order of splats: requests one at a time from the worker, and keeps the key of the last one. */

import type { SplatSink } from "../renderer/splat_drawer";
import type { OrderedSplats } from "../worker/messages";
import type { SceneWorker } from "../worker/scene_worker";
import type { Moment } from "./moment";
import { type Sight, sameSight } from "./view";

/** The key of an order. */
export interface OrderKey extends Moment, Sight {
  /** True for a view that rests; an order for a moving view is faster, and may swap splats of nearly equal depth. */
  readonly exact: boolean;
  /** Largest number of splats, the most useful ones. */
  readonly budget: number;
  /** Number of chunks decoded by the worker. */
  readonly version: number;
}

/** A request for an order, and its time. */
interface Asked {
  readonly key: OrderKey;
  readonly at: number; // ms
  readonly frame: number;
}

export class OrderRequests {
  readonly #lead = new OrderLead();
  /** Moments of further orders in use, set by their owner. */
  others: readonly Moment[] = [];
  #frame = 0;
  #now = 0; // ms
  #asked: Asked | null = null;
  #shown: Asked | null = null;
  #fresh = false; // true until a frame has used the shown order
  #ids: Uint32Array<ArrayBuffer> | undefined; // the shown order's, until the next one arrives
  #spare: Uint32Array<ArrayBuffer> | undefined;
  #count = 0;
  #dynamicSplats = 0;
  #sortTime = 0;

  constructor(
    readonly worker: Pick<SceneWorker, "order">,
    readonly sink: Pick<SplatSink, "setOrder">,
  ) {}

  /** The key of the shown order; null before the first. */
  get shown(): OrderKey | null {
    return this.#shown?.key ?? null;
  }

  /** The moments of the shown and the requested order, and `others`. */
  get moments(): Moment[] {
    return [...[this.#shown, this.#asked].flatMap((order) => order?.key ?? []), ...this.others];
  }

  /** Splats in the shown order. */
  get count(): number {
    return this.#count;
  }

  /** Dynamic splats among them. */
  get dynamicSplats(): number {
    return this.#dynamicSplats;
  }

  /** Duration of the shown order's sort in the worker, milliseconds. */
  get sortTime(): number {
    return this.#sortTime;
  }

  /** Time between the request of the shown order and the last frame, milliseconds. */
  get age(): number {
    return this.#shown ? this.#now - this.#shown.at : 0;
  }

  /** The same in frames: 1 if it was requested in the previous frame. */
  get ageInFrames(): number {
    return this.#shown ? this.#frame - this.#shown.frame : 0;
  }

  /** Expected time from the request of an order until it is shown, milliseconds. */
  get lead(): number {
    return this.#lead.duration;
  }

  /** Begin a frame, at `now`, milliseconds of the clock of all frames, with the current order. */
  frame(now: number): void {
    this.#frame++;
    this.#now = now;
    if (this.#fresh) this.#lead.note(this.age);
    this.#fresh = false;
  }

  /** Request an order unless it is there already or the worker is busy; call again at the next frame. */
  want(key: OrderKey): void {
    if (this.#asked || this.shows(key)) return;
    this.#asked = { key, at: this.#now, frame: this.#frame };
    const recycled = this.#spare;
    this.#spare = undefined;
    this.worker.order(key, recycled);
  }

  /** Take the worker's answer. */
  receive(order: OrderedSplats): void {
    this.#spare = this.#ids;
    this.#ids = order.ids;
    this.#count = order.count;
    this.#dynamicSplats = order.dynamic;
    this.#sortTime = order.sortTime;
    this.#shown = this.#asked;
    this.#asked = null;
    this.#fresh = true;
    this.sink.setOrder(order.ids, order.count);
  }

  shows(key: OrderKey): boolean {
    const shown = this.shown;
    if (key.exact && !shown?.exact) return false;
    const same = shown?.version === key.version && shown.time === key.time && shown.budget === key.budget;
    return same && sameSight(shown, key);
  }

  /** The renderer has lost its order. */
  forget(): void {
    this.#shown = null;
  }
}

const RECENT = 5;
/** Longest lead that counts, milliseconds: a suspended machine gives no measurement. */
const LONGEST = 250;

export class OrderLead {
  readonly #recent: number[] = [];

  /** Note the time between an order's request and its first frame, milliseconds. */
  note(duration: number): void {
    this.#recent.push(Math.min(LONGEST, Math.max(0, duration)));
    if (this.#recent.length > RECENT) this.#recent.shift();
  }

  /** Milliseconds: the median of the last few, which ignores single hiccups; 0 before the first. */
  get duration(): number {
    const sorted = [...this.#recent].sort((a, b) => a - b);
    return sorted[sorted.length >> 1] ?? 0;
  }
}
