/** A host's pictures of a scene: one or several per frame, from cameras and into targets of the host's. */

import { type Camera, ColorManagement, LinearTransfer, type Matrix4, Vector4, type WebGLRenderer } from "three";
import type { SplatSink } from "../renderer/splat_drawer";
import { headSight } from "../scene/head_sight";
import type { OrderKey } from "../scene/order_requests";
import type { StreamedScene } from "../scene/streamed_scene";
import type { View } from "../scene/view";
import { hostView } from "./host_view";
import { HostedSplats } from "./hosted_splats";
import { fineFormat } from "./linear_light";
import { areEyes, ViewOrders, type Views } from "./view_orders";

export interface HostPictureEvents {
  /** The last picture of a frame is drawn; `settled`: each contains everything visible at the playhead. */
  frame(settled: boolean): void;
  /** The host's context was restored, without the orders. */
  restored(): void;
}

export class HostPictures {
  readonly #splats = new HostedSplats(() => this.#restored());
  readonly #orders = new ViewOrders();
  readonly #viewport = new Vector4();
  #views: View[] = []; // this frame's, in the order of drawing
  #before: readonly View[] = []; // previous frame's
  #apart = false; // whether each view has an order of its own
  #held: OrderKey | null = null; // the drawer's order
  #settled = false;

  /**
   * Prepare for pictures.
   *
   * @param linear whether to write colours in linear light; null for the choice of three.js' materials.
   */
  constructor(
    readonly linear: boolean | null,
    readonly events: HostPictureEvents,
  ) {}

  get sink(): SplatSink {
    return this.#splats.sink;
  }

  /**
   * Draw into the bound target; `world` takes the scene's own space to the host's world.
   *
   * @throws Error with one line for people if splats cannot be drawn there.
   */
  draw(scene: StreamedScene, renderer: WebGLRenderer, camera: Camera, world: Matrix4): void {
    if (renderer.getContext().isContextLost()) return;
    const target = renderer.getRenderTarget();
    if (target && target.textures.length > 1) {
      throw new Error(`the render target has ${target.textures.length} textures: splats are drawn into one only`);
    }
    const { x, y, z: width, w: height } = currentViewport(renderer, this.#viewport);
    const viewport = { x, y, width, height };
    const { view, depth } = hostView(camera, world, viewport);
    const place = this.#views.push(view) - 1;
    if (place === 0) this.#begin(scene, renderer, [view, ...this.#before.slice(1)]);
    const kept = this.#apart ? this.#orders.at(place) : undefined;
    if (kept && kept.key !== this.#held) {
      this.#splats.setOrder(kept.ids, kept.count);
      this.#held = kept.key;
    }
    if (!this.#held) return;
    const { far = Number.POSITIVE_INFINITY } = camera as Camera & { far?: number };
    const { logarithmicDepthBuffer, reversedDepthBuffer } = renderer.capabilities;
    const linear = this.linear ?? writesLinear(renderer);
    const format = linear && target ? fineFormat(target) : null;
    const surface = {
      ...depth,
      logarithmic: logarithmicDepthBuffer ? 2 / Math.log2(far + 1) : 0,
      reversed: reversedDepthBuffer,
      linear: linear && format === null,
    };
    this.#splats.draw(scene.shot(view, this.#held), viewport, surface, format);
  }

  dispose(): void {
    this.#splats.dispose();
  }

  /** Start a frame at its first picture. The host may draw further ones until its script ends. */
  #begin(scene: StreamedScene, renderer: WebGLRenderer, views: Views): void {
    queueMicrotask(() => this.#end());
    this.#settled = false;
    const order = this.#splats.prepare(renderer);
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
    const turn = this.#orders.turn(views, playback.clock.time, version);
    const settled = scene.step(now, [views[turn]])?.settled ?? false;
    this.#settled = settled && this.#orders.all(views, playback.clock.time, version, !playback.clock.playing);
  }

  #end(): void {
    this.#before = this.#views;
    this.#views = [];
    this.events.frame(this.#settled);
  }

  #restored(): void {
    this.#held = null;
    this.#orders.forget();
    this.events.restored();
  }
}

/** The viewport in pixels. three.js has none for a canvas without a size or target set by the host. */
function currentViewport(renderer: WebGLRenderer, viewport: Vector4): Vector4 {
  if (renderer.getCurrentViewport(viewport).z > 0) return viewport;
  return renderer.getViewport(viewport).multiplyScalar(renderer.getPixelRatio()).round();
}

/** Whether three.js' materials write linear light into the bound target. */
function writesLinear(renderer: WebGLRenderer): boolean {
  const target = renderer.getRenderTarget();
  if (target === null) return ColorManagement.getTransfer(renderer.outputColorSpace) === LinearTransfer;
  const ofHeadset = (target as { isXRRenderTarget?: boolean }).isXRRenderTarget === true;
  const space = ofHeadset ? target.texture.colorSpace : ColorManagement.workingColorSpace;
  return ColorManagement.getTransfer(space) === LinearTransfer;
}
