/**
 * The picture on the canvas: drawn when it is out of date and the device has done the last one; quickly while it moves on
 * a slow device, and finely once it stands.
 */

import type { CanvasRenderer } from "../renderer/canvas_renderer";
import type { Shot } from "../renderer/shot";
import { FrameRate } from "./frame_rate";
import type { OrderRequests } from "./order_requests";
import { Stillness } from "./stillness";
import { sameView } from "./view";

export class Picture {
  readonly frames = new FrameRate();
  readonly #stillness = new Stillness();
  #drawn: Shot | null = null; // null when the picture is out of date
  #quick = false; // how it was drawn
  #first: number | null = null;

  constructor(
    readonly renderer: CanvasRenderer,
    readonly orders: OrderRequests,
  ) {}

  /** Milliseconds from opening the page to the first picture; null before. */
  get first(): number | null {
    return this.#first;
  }

  /** The order has changed, or the canvas was lost. */
  outdate(): void {
    this.#drawn = null;
  }

  /** Whether `shot` is drawn as well as it can be; while the scene moves, as well as it is drawn in motion. */
  shows(shot: Shot, moving: boolean): boolean {
    return !this.renderer.lost && this.#current(shot) && (moving || !this.#quick);
  }

  /**
   * Draw if it is time to; called once per frame of the browser. `moving`: the scene moves. `now` in milliseconds.
   *
   * Returns whether the next frame may draw more although nothing has changed until then.
   */
  update(shot: Shot, moving: boolean, now: number): boolean {
    const still = this.#stillness.update(shot, moving, now);
    const drawn = this.#draw(shot, this.renderer.slow && !still, now);
    if (moving && !drawn) this.frames.drop();
    // Also until the device is done, because only then its pace is known.
    return !this.renderer.lost && (this.renderer.busy(now) || (this.#quick && !moving));
  }

  /** Note a frame drawn at `now`, milliseconds, on the canvas or elsewhere. */
  countFrame(now: number): void {
    this.frames.count(now);
    if (this.#first === null && this.orders.count > 0) this.#first = performance.now();
  }

  #draw(shot: Shot, quick: boolean, now: number): boolean {
    const current = this.#current(shot) && (quick || !this.#quick);
    if (current || this.renderer.lost || this.renderer.busy(now)) return false;
    this.renderer.draw(shot, quick);
    this.#drawn = shot;
    this.#quick = quick;
    this.countFrame(now);
    return true;
  }

  #current(shot: Shot): boolean {
    return sameView(this.#drawn, shot) && this.#drawn?.time === shot.time;
  }
}
