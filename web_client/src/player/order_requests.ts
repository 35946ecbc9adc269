/** Keeps the order of the splats up to date: asks the worker for one at a time, and remembers what the last one is of. */

import type { SplatSink } from "../renderer/splat_drawer";
import { type SplatDepth, sameDepth } from "../worker/depth";
import type { OrderedSplats } from "../worker/messages";
import type { SceneWorker } from "../worker/scene_worker";

/** What an order is of. */
export interface OrderKey {
  readonly depth: SplatDepth;
  /** Seconds. */
  readonly time: number;
  /** Counts what the worker has decoded. */
  readonly version: number;
}

export class OrderRequests {
  #asked: OrderKey | null = null;
  #askedAt = 0; // ms
  #shown: OrderKey | null = null;
  #shownAskedAt = 0; // ms
  #ids: Uint32Array<ArrayBuffer> | undefined; // of the order that is shown, until the next one comes
  #spare: Uint32Array<ArrayBuffer> | undefined;
  #normalisedTime = 0;
  #count = 0;
  #dynamicSplats = 0;
  #sortTime = 0;

  constructor(
    readonly worker: Pick<SceneWorker, "order">,
    readonly sink: Pick<SplatSink, "setOrder">,
  ) {}

  /** What the order that is drawn now is of; null before the first. */
  get shown(): OrderKey | null {
    return this.#shown;
  }

  /** The segment's time at which the shown order's dynamics are to be drawn. */
  get normalisedTime(): number {
    return this.#normalisedTime;
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

  /** How long before `now` the shown order was asked for, milliseconds of `performance.now()`. */
  age(now: number): number {
    return now - this.#shownAskedAt;
  }

  /** Ask for an order unless it is there already or the worker is busy with one; call again at the next frame. */
  want(key: OrderKey): void {
    if (this.#asked || this.shows(key)) return;
    this.#asked = key;
    this.#askedAt = performance.now();
    const { depth, time } = key;
    const recycled = this.#spare;
    this.#spare = undefined;
    this.worker.order(depth, time, recycled);
  }

  /** Take the worker's answer. */
  receive(order: OrderedSplats): void {
    this.#spare = this.#ids;
    this.#ids = order.ids;
    this.#normalisedTime = order.normalisedTime;
    this.#count = order.count;
    this.#dynamicSplats = order.dynamic;
    this.#sortTime = order.sortTime;
    this.#shown = this.#asked;
    this.#shownAskedAt = this.#askedAt;
    this.#asked = null;
    this.sink.setOrder(order.ids, order.count);
  }

  shows(key: OrderKey): boolean {
    const shown = this.#shown;
    return (
      shown !== null && shown.version === key.version && shown.time === key.time && sameDepth(shown.depth, key.depth)
    );
  }

  /** The renderer has lost its order. */
  forget(): void {
    this.#shown = null;
  }
}
