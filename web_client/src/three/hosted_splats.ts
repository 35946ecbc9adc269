/**
 * The splats in the context of a host's renderer: created, filled and drawn while the host draws, with its bindings
 * kept.
 */

import type { WebGLRenderer } from "three";
import type { Viewport } from "../camera/projection";
import type { Shot } from "../renderer/shot";
import { FEWEST_ROWS, SplatDrawer, type SplatSink } from "../renderer/splat_drawer";
import { type HostSurface, HostSurroundings } from "./host_surface";
import { keepBindings, keepUnpacking } from "./kept_state";
import { LinearLight } from "./linear_light";
import { WaitingSplats } from "./waiting_splats";

export class HostedSplats {
  readonly #waiting = new WaitingSplats(() => this.#renderer?.capabilities.maxTextureSize ?? mostRowsHere());
  readonly #host = new HostSurroundings();
  readonly #listeners = new AbortController();
  #renderer: WebGLRenderer | null = null;
  #drawer: SplatDrawer | null = null;
  #light: LinearLight | null = null;
  #stale = false; // true after a loss of the context

  /**
   * Wait for a renderer.
   *
   * @param onLoss called when the context was restored: then splats and an order must be set again.
   */
  constructor(readonly onLoss: () => void) {}

  /** The sink for decoded splats and their order, at any time. */
  get sink(): SplatSink {
    return this.#waiting;
  }

  /**
   * Take the splats received since the last frame.
   *
   * @returns the new order, if there is one: ids and their number, in a borrowed array.
   * @throws Error if another renderer has drawn the scene before, or the device cannot hold it.
   */
  prepare(renderer: WebGLRenderer): Parameters<SplatSink["setOrder"]> | null {
    const gl = this.#contextOf(renderer);
    if (this.#drawer && !this.#stale && this.#waiting.empty) return null;
    return keepUnpacking(gl, () => {
      if (!this.#drawer) this.#drawer = new SplatDrawer(gl, this.#host);
      else if (this.#stale) this.#drawer.rebuild();
      if (this.#stale) this.#light = null;
      this.#stale = false;
      return this.#waiting.flush(this.#drawer);
    });
  }

  /** Replace the last order by an earlier one. */
  setOrder(...order: Parameters<SplatSink["setOrder"]>): void {
    const drawer = this.#drawer;
    if (drawer) keepUnpacking(drawer.gl, () => drawer.setOrder(...order));
  }

  /**
   * Draw a shot.
   *
   * @param light the format of the bound target, if it holds linear light to be converted to sRGB meanwhile.
   */
  draw(shot: Shot, viewport: Viewport, surface: HostSurface, light: "RGBA16F" | "RGBA32F" | null): void {
    const drawer = this.#drawer;
    if (!drawer || drawer.count === 0) return;
    const { gl } = drawer;
    const draw = () => drawer.draw(shot, [viewport.x, viewport.y]);
    this.#host.surface = surface;
    keepBindings(gl, () => {
      if (light === null) draw();
      else {
        this.#light ??= new LinearLight(gl);
        this.#light.around(viewport, light, draw);
      }
    });
  }

  /** Delete the contents of the context, which stays the host's. */
  dispose(): void {
    this.#listeners.abort();
    this.#drawer?.dispose();
    this.#light?.dispose();
    this.#drawer = null;
  }

  #contextOf(renderer: WebGLRenderer): WebGL2RenderingContext {
    if (this.#renderer !== null && this.#renderer !== renderer) {
      throw new Error("this HgsScene has been drawn by another renderer: each needs one of its own");
    }
    if (this.#renderer === null) {
      this.#renderer = renderer;
      const restored = () => {
        this.#stale = true;
        this.onLoss();
      };
      renderer.domElement.addEventListener("webglcontextrestored", restored, { signal: this.#listeners.signal });
    }
    return renderer.getContext() as WebGL2RenderingContext;
  }
}

/** Texture rows that this device supports, before the host's renderer is known. */
function mostRowsHere(): number {
  const gl = new OffscreenCanvas(1, 1).getContext("webgl2");
  const rows = gl?.getParameter(gl.MAX_TEXTURE_SIZE) ?? FEWEST_ROWS;
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return rows;
}
