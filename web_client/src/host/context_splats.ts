/**
 * The splats in a host's context of WebGL2: created, filled and drawn while the host draws, with its bindings kept.
 */

import type { Viewport } from "../camera/projection";
import type { Shot } from "../renderer/shot";
import { SplatDrawer, type SplatSink } from "../renderer/splat_drawer";
import { type HostSurface, HostSurroundings } from "./host_surface";
import { keepBindings, keepUnpacking } from "./kept_state";
import { type FineFormat, LinearLight } from "./linear_light";
import { WaitingSplats } from "./waiting_splats";

export class ContextSplats {
  readonly #waiting: WaitingSplats;
  readonly #host = new HostSurroundings();
  #drawer: SplatDrawer | null = null;
  #light: LinearLight | null = null;
  #stale = false; // true after a loss of the context

  /**
   * Wait for a context.
   *
   * @param mostRows texture rows that the device supports.
   */
  constructor(mostRows: () => number) {
    this.#waiting = new WaitingSplats(mostRows);
  }

  get sink(): SplatSink {
    return this.#waiting;
  }

  /** The context was lost, and is there again. */
  restored(): void {
    this.#stale = true;
  }

  /** Take the splats that wait; see `HostDrawer.prepare`. */
  prepare(gl: WebGL2RenderingContext): Parameters<SplatSink["setOrder"]> | null {
    if (this.#drawer && !this.#stale && this.#waiting.empty) return null;
    return keepUnpacking(gl, () => {
      if (!this.#drawer) this.#drawer = new SplatDrawer(gl, this.#host);
      else if (this.#stale) this.#drawer.rebuild();
      if (this.#stale) this.#light = null;
      this.#stale = false;
      return this.#waiting.flush(this.#drawer);
    });
  }

  setOrder(...order: Parameters<SplatSink["setOrder"]>): void {
    const drawer = this.#drawer;
    if (drawer) keepUnpacking(drawer.gl, () => drawer.setOrder(...order));
  }

  /**
   * Draw a shot into the bound target.
   *
   * @param format of a target that is fine enough for its linear light to be turned into sRGB and back; else null.
   */
  draw(viewport: Viewport, shot: Shot, surface: HostSurface, format: FineFormat | null): void {
    const drawer = this.#drawer;
    if (!drawer || drawer.count === 0) return;
    const { gl } = drawer;
    const turned = surface.linear ? format : null;
    const draw = () => drawer.draw(shot, [viewport.x, viewport.y]);
    this.#host.surface = { ...surface, linear: surface.linear && turned === null };
    keepBindings(gl, () => {
      if (turned === null) draw();
      else {
        this.#light ??= new LinearLight(gl);
        this.#light.around(viewport, turned, surface.exponent, draw);
      }
    });
  }

  /** Delete the contents of the context, which stays the host's. */
  dispose(): void {
    this.#drawer?.dispose();
    this.#light?.dispose();
    this.#drawer = null;
  }
}
