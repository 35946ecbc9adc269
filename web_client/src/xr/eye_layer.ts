/** The layer of a session's eyes: their framebuffer, and its fineness. */

import { comfortableRate, EyeQualityControl } from "./eye_quality";

/** The near and far planes of the session's projections, metres; flat objects are drawn between them. */
export const NEAR = 0.05;
const FAR = 100;

export class EyeLayer {
  readonly #quality: EyeQualityControl;
  #lost: XRWebGLLayer | null = null;

  constructor(
    readonly session: XRSession,
    readonly gl: WebGL2RenderingContext,
  ) {
    const rate = comfortableRate(session.supportedFrameRates);
    this.#quality = new EyeQualityControl(rate ?? session.frameRate ?? 72);
    // Some headsets list rates that they then refuse, and keep their own.
    if (rate !== null) void session.updateTargetFrameRate?.(rate).catch(() => {});
    session.addEventListener("frameratechange", () => {
      this.#quality.frameRate = session.frameRate ?? this.#quality.frameRate;
    });
  }

  /** Create the framebuffer, also after a restoration of the context. */
  async create(): Promise<void> {
    await this.gl.makeXRCompatible();
    this.#make();
  }

  /** The context is lost, and the framebuffer with it. */
  forget(): void {
    this.#lost = this.session.renderState.baseLayer ?? null;
  }

  /** The layer for a frame at `now`, milliseconds; null while there is none. */
  begin(now: number): XRWebGLLayer | null {
    const layer = this.session.renderState.baseLayer;
    if (!layer || layer === this.#lost || this.gl.isContextLost()) return null;
    if (this.#quality.frame(now)) {
      if (scalesViewports()) this.#foveate(layer);
      else this.#make(); // visible from the next frame on
    }
    return layer;
  }

  /** The part of the framebuffer that a view is drawn into; null if it shows nothing. */
  viewport(layer: XRWebGLLayer, view: XRView): XRViewport | null {
    if (scalesViewports()) view.requestViewportScale?.(this.#quality.quality.scale);
    const viewport = layer.getViewport(view);
    return viewport && viewport.width > 0 && viewport.height > 0 ? viewport : null;
  }

  /** Largest number of splats for each eye. */
  get splats(): number {
    return this.#quality.quality.splats;
  }

  /** Ignore an interruption of frames with a reason of its own. */
  interrupted(): void {
    this.#quality.interrupted();
  }

  #make(): void {
    const layer = new XRWebGLLayer(this.session, this.gl, {
      antialias: false, // splats have no edges
      depth: false,
      stencil: false,
      alpha: true,
      framebufferScaleFactor: scalesViewports() ? 1 : this.#quality.quality.scale,
    });
    this.#foveate(layer);
    void this.session.updateRenderState({ baseLayer: layer, depthNear: NEAR, depthFar: FAR });
  }

  #foveate(layer: XRWebGLLayer): void {
    if (typeof layer.fixedFoveation === "number") layer.fixedFoveation = this.#quality.quality.foveation;
  }
}

/** Whether the browser scales viewports from frame to frame; otherwise the framebuffer is created again. */
const scalesViewports = (): boolean => typeof XRView !== "undefined" && "requestViewportScale" in XRView.prototype;
