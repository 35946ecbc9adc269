/** A host's pictures of a scene: one or several per frame, from cameras and into targets of the host's. */

import { headSight } from "../scene/head_sight";
import type { OrderKey } from "../scene/order_requests";
import type { StreamedScene } from "../scene/streamed_scene";
import type { View } from "../scene/view";
import type { HostDrawer } from "./host_drawer";
import { hostView } from "./host_view";
import { areEyes, ViewOrders, type Views } from "./view_orders";

export class HostPictures<Turn> {
  readonly #orders = new ViewOrders();
  #views: View[] = []; // this frame's, in the order of drawing
  #before: readonly View[] = []; // previous frame's
  #apart = false; // whether each view has an order of its own
  #held: OrderKey | null = null; // the drawer's order
  #settled = false;

  /**
   * Prepare for pictures.
   *
   * @param framed called when the last picture of a frame is drawn; `settled`: each contains everything visible at the
   *   playhead.
   */
  constructor(
    readonly drawer: HostDrawer<Turn>,
    readonly framed: (settled: boolean) => void,
  ) {}

  /**
   * Draw into the bound target.
   *
   * @throws Error with one line for people if splats cannot be drawn there.
   */
  draw(scene: StreamedScene, turn: Turn): void {
    const picture = this.drawer.picture(turn);
    if (!picture) return;
    const { view, depth } = hostView(picture, picture.viewport);
    const place = this.#views.push(view) - 1;
    if (place === 0) this.#begin(scene, turn, [view, ...this.#before.slice(1)]);
    const kept = this.#apart ? this.#orders.at(place) : undefined;
    if (kept && kept.key !== this.#held) {
      this.drawer.setOrder(kept.ids, kept.count);
      this.#held = kept.key;
    }
    if (this.#held) this.drawer.draw(turn, picture.viewport, scene.shot(view, this.#held), depth);
  }

  /** Forget the orders of a lost context. */
  forget(): void {
    this.#held = null;
    this.#orders.forget();
  }

  /** Start a frame at its first picture. The host may draw further ones until its script ends. */
  #begin(scene: StreamedScene, turn: Turn, views: Views): void {
    queueMicrotask(() => this.#end());
    this.#settled = false;
    const order = this.drawer.prepare(turn);
    if (order) {
      this.#held = scene.orders.shown;
      const taken = this.#held && this.#apart ? this.#orders.take(this.#held, ...order) : true;
      if (!taken) scene.orders.forget();
    }
    scene.orders.others = [...this.#orders.keys, ...(this.#held ? [this.#held] : [])];
    const { manifest, playback, version } = scene;
    if (!manifest || !playback) return;
    const apart = !areEyes(views, manifest.extent);
    if (apart !== this.#apart) {
      this.#apart = apart;
      this.#orders.forget();
      scene.orders.forget(); // the drawer's order may be another view's
    }
    const now = performance.now();
    if (!apart) {
      this.#settled = scene.step(now, views, headSight(views))?.settled ?? false;
      return;
    }
    const place = this.#orders.turn(views, playback.clock.time, version);
    const settled = scene.step(now, [views[place]])?.settled ?? false;
    this.#settled = settled && this.#orders.all(views, playback.clock.time, version, !playback.clock.playing);
  }

  #end(): void {
    this.#before = this.#views;
    this.#views = [];
    this.framed(this.#settled);
  }
}
