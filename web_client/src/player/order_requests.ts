/** Keeps the order of the splats up to date: asks the worker for one at a time, and remembers what the last one is of. */

import type { SplatRenderer } from "../renderer/renderer";
import type { FromWorker, ToWorker } from "../worker/messages";
import { type DepthAxis, sameAxis } from "../worker/splat_order";
import type { View } from "./view";

/** What an order is of. */
export interface OrderKey {
  readonly axis: DepthAxis;
  /** Seconds. */
  readonly time: number;
  /** Counts what the worker has decoded. */
  readonly version: number;
}

/** What the order for a view at `time`, seconds, is of. */
export function orderKey({ pose, camera }: View, time: number, version: number): OrderKey {
  const r = pose.rotation;
  return { axis: { x: r[6], y: r[7], z: r[8], offset: pose.translation[2], near: camera.near }, time, version };
}

type Ordered = Extract<FromWorker, { type: "ordered" }>;

export class OrderRequests {
  #asked: OrderKey | null = null;
  #askedAt = 0; // ms
  #shown: OrderKey | null = null;
  #shownAskedAt = 0; // ms
  #ids: Uint32Array<ArrayBuffer> | undefined; // of the order that is shown, until the next one comes
  #spare: Uint32Array<ArrayBuffer> | undefined;
  #normalisedTime = 0;
  #dynamicSplats = 0;
  #sortTime = 0;

  constructor(
    readonly tell: (message: ToWorker, transfer: Transferable[]) => void,
    readonly renderer: SplatRenderer,
  ) {}

  /** What the order that is drawn now is of; null before the first. */
  get shown(): OrderKey | null {
    return this.#shown;
  }

  /** The segment's time at which the shown order's dynamics are to be drawn. */
  get normalisedTime(): number {
    return this.#normalisedTime;
  }

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
    const { axis, time } = key;
    const recycled = this.#spare;
    this.#spare = undefined;
    if (recycled) this.tell({ type: "order", axis, time, recycled }, [recycled.buffer]);
    else this.tell({ type: "order", axis, time }, []);
  }

  /** Take the worker's answer. */
  receive(order: Ordered): void {
    this.#spare = this.#ids;
    this.#ids = order.ids;
    this.#normalisedTime = order.normalisedTime;
    this.#dynamicSplats = order.dynamic;
    this.#sortTime = order.sortTime;
    this.#shown = this.#asked;
    this.#shownAskedAt = this.#askedAt;
    this.#asked = null;
    this.renderer.setOrder(order.ids, order.count);
  }

  shows(key: OrderKey): boolean {
    const shown = this.#shown;
    return shown !== null && shown.version === key.version && shown.time === key.time && sameAxis(shown.axis, key.axis);
  }

  /** The renderer has lost its order. */
  forget(): void {
    this.#shown = null;
  }
}
