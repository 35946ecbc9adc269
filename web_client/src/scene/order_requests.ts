/** Keeps the order of the splats up to date: asks the worker for one at a time, and remembers what the last one is of. */

import type { SplatSink } from "../renderer/splat_drawer";
import type { OrderedSplats } from "../worker/messages";
import type { SceneWorker } from "../worker/scene_worker";
import type { Moment } from "./moment";
import { type Sight, sameSight } from "./view";

/** What an order is of. */
export interface OrderKey extends Moment, Sight {
  /** Of a view that stands; one that moves has an order that is quicker and may swap splats of all but the same depth. */
  readonly exact: boolean;
  /** So many splats are in it at most, the most useful ones. */
  readonly budget: number;
  /** Counts what the worker has decoded. */
  readonly version: number;
}

/** An order, and when it was asked for. */
interface Asked {
  readonly key: OrderKey;
  readonly at: number; // ms
  readonly frame: number;
}

export class OrderRequests {
  readonly #lead = new OrderLead();
  /** Moments of further orders that are drawn; of whoever keeps some. */
  others: readonly Moment[] = [];
  #frame = 0;
  #now = 0; // ms
  #asked: Asked | null = null;
  #shown: Asked | null = null;
  #fresh = false; // no frame has seen the shown order yet
  #ids: Uint32Array<ArrayBuffer> | undefined; // of the order that is shown, until the next one comes
  #spare: Uint32Array<ArrayBuffer> | undefined;
  #count = 0;
  #dynamicSplats = 0;
  #sortTime = 0;

  constructor(
    readonly worker: Pick<SceneWorker, "order">,
    readonly sink: Pick<SplatSink, "setOrder">,
  ) {}

  /** What the order that is drawn now is of; null before the first. */
  get shown(): OrderKey | null {
    return this.#shown?.key ?? null;
  }

  /** The moments of the order that is shown, of the one that is asked for, and of `others`. */
  get moments(): Moment[] {
    return [...[this.#shown, this.#asked].flatMap((order) => order?.key ?? []), ...this.others];
  }

  /** Splats in the shown order. */
  get count(): number {
    return this.#count;
  }

  /** Those of them that move. */
  get dynamicSplats(): number {
    return this.#dynamicSplats;
  }

  /** How long the worker needed for the shown order, milliseconds. */
  get sortTime(): number {
    return this.#sortTime;
  }

  /** How long before the last frame the shown order was asked for, milliseconds. */
  get age(): number {
    return this.#shown ? this.#now - this.#shown.at : 0;
  }

  /** The same in frames: 1 if the frame before asked for it. */
  get ageInFrames(): number {
    return this.#shown ? this.#frame - this.#shown.frame : 0;
  }

  /** How long after it has been asked for an order is likely to be shown, milliseconds. */
  get lead(): number {
    return this.#lead.duration;
  }

  /** A frame begins, at `now`, milliseconds of the clock of all frames; it shows the order that there is. */
  frame(now: number): void {
    this.#frame++;
    this.#now = now;
    if (this.#fresh) this.#lead.note(this.age);
    this.#fresh = false;
  }

  /** Ask for an order unless it is there already or the worker is busy with one; call again at the next frame. */
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
/** Longest lead that is believed, milliseconds: a machine that has been asleep is no measure. */
const LONGEST = 250;

export class OrderLead {
  readonly #recent: number[] = [];

  /** Note that an order was shown so many milliseconds after it was asked for. */
  note(duration: number): void {
    this.#recent.push(Math.min(LONGEST, Math.max(0, duration)));
    if (this.#recent.length > RECENT) this.#recent.shift();
  }

  /** Milliseconds: the median of the last few, which one hiccup does not move; 0 before the first. */
  get duration(): number {
    const sorted = [...this.#recent].sort((a, b) => a - b);
    return sorted[sorted.length >> 1] ?? 0;
  }
}
