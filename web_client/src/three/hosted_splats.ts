/**
 * The splats in the context of a host's renderer: created, filled and drawn while the host draws, with its bindings
 * kept.
 */

import { type Camera, ColorManagement, LinearTransfer, Vector4, type WebGLRenderer } from "three";
import type { Viewport } from "../camera/projection";
import type { Manifest } from "../codec/types";
import type { Shot } from "../renderer/shot";
import { FEWEST_ROWS, SplatDrawer, type SplatSink } from "../renderer/splat_drawer";
import type { HostDrawer, HostDrawing } from "./host_drawer";
import { HostSurroundings } from "./host_surface";
import type { HostView } from "./host_view";
import { keepBindings, keepUnpacking } from "./kept_state";
import { fineFormat, LinearLight } from "./linear_light";
import { SplatMesh } from "./splat_mesh";
import { WaitingSplats } from "./waiting_splats";

export class HostedSplats implements HostDrawer<WebGLRenderer> {
  readonly object: SplatMesh;
  readonly #waiting = new WaitingSplats(() => this.#renderer?.capabilities.maxTextureSize ?? mostRowsHere());
  readonly #host = new HostSurroundings();
  readonly #listeners = new AbortController();
  readonly #viewport = new Vector4();
  #renderer: WebGLRenderer | null = null;
  #drawer: SplatDrawer | null = null;
  #light: LinearLight | null = null;
  #stale = false; // true after a loss of the context

  /**
   * Wait for a renderer.
   *
   * @param linear whether to write colours in linear light; null for the choice of three.js' materials.
   */
  constructor(
    readonly linear: boolean | null,
    readonly drawing: HostDrawing<WebGLRenderer>,
  ) {
    this.object = new SplatMesh((renderer, camera) => drawing.draw(renderer, camera));
  }

  get sink(): SplatSink {
    return this.#waiting;
  }

  bound(manifest: Manifest): void {
    this.object.bound(manifest);
  }

  viewport(renderer: WebGLRenderer): Viewport | null {
    if (!("isWebGLRenderer" in renderer)) {
      throw new Error("this renderer is no WebGLRenderer: import HgsScene from @hgs/player/three-webgpu instead");
    }
    if (renderer.getContext().isContextLost()) return null;
    const target = renderer.getRenderTarget();
    if (target && target.textures.length > 1) {
      throw new Error(`the render target has ${target.textures.length} textures: splats are drawn into one only`);
    }
    const { x, y, z: width, w: height } = currentViewport(renderer, this.#viewport);
    return { x, y, width, height };
  }

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

  setOrder(...order: Parameters<SplatSink["setOrder"]>): void {
    const drawer = this.#drawer;
    if (drawer) keepUnpacking(drawer.gl, () => drawer.setOrder(...order));
  }

  draw(renderer: WebGLRenderer, camera: Camera, viewport: Viewport, shot: Shot, depth: HostView["depth"]): void {
    const drawer = this.#drawer;
    if (!drawer || drawer.count === 0) return;
    const { gl } = drawer;
    const { far = Number.POSITIVE_INFINITY } = camera as Camera & { far?: number };
    const { logarithmicDepthBuffer, reversedDepthBuffer } = renderer.capabilities;
    const target = renderer.getRenderTarget();
    const linear = this.linear ?? writesLinear(renderer);
    const format = linear && target ? fineFormat(target) : null;
    const draw = () => drawer.draw(shot, [viewport.x, viewport.y]);
    this.#host.surface = {
      ...depth,
      logarithmic: logarithmicDepthBuffer ? 2 / Math.log2(far + 1) : 0,
      reversed: reversedDepthBuffer,
      linear: linear && format === null,
    };
    keepBindings(gl, () => {
      if (format === null) draw();
      else {
        this.#light ??= new LinearLight(gl);
        this.#light.around(viewport, format, draw);
      }
    });
  }

  /** Delete the contents of the context, which stays the host's. */
  dispose(): void {
    this.#listeners.abort();
    this.#drawer?.dispose();
    this.#light?.dispose();
    this.object.dispose();
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
        this.drawing.restored();
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
