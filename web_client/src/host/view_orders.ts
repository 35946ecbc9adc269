/**
 * Orders for several views that a host draws in every frame, such as two viewports. Each view has its own; they are
 * made in turns, and kept here while another one is in the drawer.
 */

import { eyeOf } from "../camera/pinhole";
import { length, subtract } from "../camera/vector";
import { TEXTURE_WIDTH } from "../renderer/layout";
import type { OrderKey } from "../scene/order_requests";
import { sameSight, sightOf, type View } from "../scene/view";

export type Views = readonly [View, ...View[]];

/**
 * Distance of views, relative to the scene's extent, below which they are two eyes: one order by distance serves both.
 */
const EYES = 0.1;

/** Whether one order serves all the views. */
export function areEyes(views: Views, extent: number): boolean {
  const [first, ...others] = views.map((view) => eyeOf(view.pose));
  return others.every((eye) => length(subtract(eye, first)) <= EYES * extent);
}

interface KeptOrder {
  readonly key: OrderKey;
  readonly ids: Uint32Array;
  readonly count: number;
}

export class ViewOrders {
  #kept: (KeptOrder | undefined)[] = []; // orders by the views' places in the frame
  #turn = 0;
  #asked: View | null = null; // view of the next order

  /** The place of the next view to be ordered; `time` and `version` are the scene's present ones. */
  turn(views: Views, time: number, version: number): number {
    this.#kept.length = Math.min(this.#kept.length, views.length);
    if (this.#turn >= views.length) [this.#turn, this.#asked] = [0, null];
    if (this.#asked) return this.#turn;
    // A view with a quick order gets its exact one before the others' turn.
    const first = this.#upToDate(this.#turn, views[this.#turn], time, version, false) ? 0 : 1;
    for (let step = first; step <= views.length; step++) {
      const place = (this.#turn + step) % views.length;
      if (this.#upToDate(place, views[place], time, version)) continue;
      [this.#turn, this.#asked] = [place, views[place]];
      break;
    }
    return this.#turn;
  }

  /** Keep a new order, in a borrowed array. False if it was requested before the first turn. */
  take(key: OrderKey, ids: Uint32Array, count: number): boolean {
    const awaited = this.#asked !== null && sameSight(sightOf([this.#asked]), key);
    if (awaited) {
      const rows = Math.ceil(count / TEXTURE_WIDTH);
      this.#kept[this.#turn] = { key, ids: ids.slice(0, rows * TEXTURE_WIDTH), count };
    }
    this.#asked = null;
    return awaited;
  }

  /** The order of the view at that place in the frame; undefined before its first. */
  at(place: number): KeptOrder | undefined {
    return this.#kept[place];
  }

  /** The keys of the orders kept here. */
  get keys(): OrderKey[] {
    return this.#kept.flatMap((order) => order?.key ?? []);
  }

  /** Whether all views have an order, and, if required, an exact one. */
  all(views: Views, time: number, version: number, exact: boolean): boolean {
    return views.every((view, place) => (exact ? this.#upToDate(place, view, time, version) : this.#kept[place]));
  }

  forget(): void {
    this.#kept = [];
    this.#asked = null;
  }

  #upToDate(place: number, view: View, time: number, version: number, exact = true): boolean {
    const key = this.#kept[place]?.key;
    if (!key || (exact && !key.exact)) return false;
    return key.time === time && key.version === version && sameSight(key, sightOf([view]));
  }
}
