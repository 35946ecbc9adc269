/** The splats in the pictures of a `WebGLRenderer`. */

import {
  ColorManagement,
  FloatType,
  HalfFloatType,
  LinearTransfer,
  RGBAFormat,
  Vector4,
  type WebGLRenderer,
  type WebGLRenderTarget,
} from "three";
import type { Viewport } from "../camera/projection";
import type { Manifest } from "../codec/types";
import { ContextSplats } from "../host/context_splats";
import type { HostPicture } from "../host/host_drawer";
import type { HostDepth } from "../host/host_view";
import type { FineFormat } from "../host/linear_light";
import type { Shot } from "../renderer/shot";
import { FEWEST_ROWS, type SplatSink } from "../renderer/splat_drawer";
import { SplatMesh } from "./splat_mesh";
import { threePicture } from "./three_camera";
import type { ThreeDrawer, ThreeDrawing, ThreeTurn } from "./three_drawer";

type Turn = ThreeTurn<WebGLRenderer>;

export class HostedSplats implements ThreeDrawer<WebGLRenderer> {
  readonly object: SplatMesh;
  readonly #splats = new ContextSplats(() => this.#renderer?.capabilities.maxTextureSize ?? mostRowsHere());
  readonly #listeners = new AbortController();
  readonly #viewport = new Vector4();
  #renderer: WebGLRenderer | null = null;

  /**
   * Wait for a renderer.
   *
   * @param linear whether to write colours in linear light; null for the choice of three.js' materials.
   */
  constructor(
    readonly linear: boolean | null,
    readonly drawing: ThreeDrawing<WebGLRenderer>,
  ) {
    this.object = new SplatMesh((renderer, camera) => drawing.draw(renderer, camera));
  }

  get sink(): SplatSink {
    return this.#splats.sink;
  }

  bound(manifest: Manifest): void {
    this.object.bound(manifest);
  }

  picture({ renderer, camera, world }: Turn): HostPicture | null {
    if (!("isWebGLRenderer" in renderer)) {
      throw new Error("this renderer is no WebGLRenderer: import HgsScene from @hgs/player/three-webgpu instead");
    }
    if (renderer.getContext().isContextLost()) return null;
    const target = renderer.getRenderTarget();
    if (target && target.textures.length > 1) {
      throw new Error(`the render target has ${target.textures.length} textures: splats are drawn into one only`);
    }
    const { x, y, z: width, w: height } = currentViewport(renderer, this.#viewport);
    return threePicture(camera, world, { x, y, width, height });
  }

  prepare({ renderer }: Turn): Parameters<SplatSink["setOrder"]> | null {
    return this.#splats.prepare(this.#contextOf(renderer));
  }

  setOrder(...order: Parameters<SplatSink["setOrder"]>): void {
    this.#splats.setOrder(...order);
  }

  draw({ renderer, camera }: Turn, viewport: Viewport, shot: Shot, depth: HostDepth): void {
    const { far = Number.POSITIVE_INFINITY } = camera as typeof camera & { far?: number };
    const { logarithmicDepthBuffer, reversedDepthBuffer } = renderer.capabilities;
    const target = renderer.getRenderTarget();
    const surface = {
      ...depth,
      logarithmic: logarithmicDepthBuffer ? 2 / Math.log2(far + 1) : 0,
      reversed: reversedDepthBuffer,
      linear: this.linear ?? writesLinear(renderer),
      exponent: 0,
    };
    this.#splats.draw(viewport, shot, surface, target && fineFormat(target));
  }

  /** Delete the contents of the context, which stays the host's. */
  dispose(): void {
    this.#listeners.abort();
    this.#splats.dispose();
    this.object.dispose();
  }

  #contextOf(renderer: WebGLRenderer): WebGL2RenderingContext {
    if (this.#renderer !== null && this.#renderer !== renderer) {
      throw new Error("this HgsScene has been drawn by another renderer: each needs one of its own");
    }
    if (this.#renderer === null) {
      this.#renderer = renderer;
      const restored = () => {
        this.#splats.restored();
        this.drawing.restored();
      };
      renderer.domElement.addEventListener("webglcontextrestored", restored, { signal: this.#listeners.signal });
    }
    return renderer.getContext() as WebGL2RenderingContext;
  }
}

/** The format of a target's colours, if it is a fine one. */
function fineFormat({ texture }: WebGLRenderTarget): FineFormat | null {
  if (texture.format !== RGBAFormat) return null;
  return texture.type === HalfFloatType ? "RGBA16F" : texture.type === FloatType ? "RGBA32F" : null;
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
