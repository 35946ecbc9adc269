/** The splats in the pictures of a PlayCanvas application. */

import {
  type AppBase,
  type CameraComponent,
  type Entity,
  GAMMA_SRGB,
  type GraphicsDevice,
  Mat4,
  PIXELFORMAT_RGBA16F,
  PIXELFORMAT_RGBA32F,
  type WebglGraphicsDevice,
} from "playcanvas";
import type { Viewport } from "../camera/projection";
import type { Manifest } from "../codec/types";
import { ContextSplats } from "../host/context_splats";
import type { HostDrawer, HostDrawing, HostPicture } from "../host/host_drawer";
import type { HostDepth } from "../host/host_view";
import type { FineFormat } from "../host/linear_light";
import type { Shot } from "../renderer/shot";
import type { SplatSink } from "../renderer/splat_drawer";
import { SplatInstance } from "./splat_instance";

const FINE: ReadonlyMap<number | undefined, FineFormat> = new Map([
  [PIXELFORMAT_RGBA16F, "RGBA16F"],
  [PIXELFORMAT_RGBA32F, "RGBA32F"],
]);

/** The engine's curve from colours to linear light. */
const EXPONENT = 2.2;

/** The turn is that of a camera, which PlayCanvas has prepared for drawing. */
export class EntitySplats implements HostDrawer<CameraComponent> {
  readonly instance: SplatInstance;
  readonly #device: WebglGraphicsDevice;
  readonly #splats: ContextSplats;
  readonly #listening: { off(): void }[];
  #camera: CameraComponent | null = null; // the one whose layer is drawn

  /**
   * Prepare for pictures.
   *
   * @param entity with the scene's own space.
   * @param linear whether to write colours in linear light; null for the choice of the engine's materials.
   * @throws Error with one line for people if the application does not draw by WebGL2.
   */
  constructor(
    readonly app: AppBase,
    readonly entity: Entity,
    readonly linear: boolean | null,
    drawing: HostDrawing<CameraComponent>,
  ) {
    const device = webgl2(app.graphicsDevice);
    this.#device = device;
    this.#splats = new ContextSplats(() => device.maxTextureSize);
    this.instance = new SplatInstance(device, entity, () => this.#camera && drawing.draw(this.#camera));
    this.#listening = [
      app.scene.on("prerender:layer", (camera: CameraComponent) => {
        this.#camera = camera;
      }),
      device.on("devicerestored", () => {
        this.#splats.restored();
        drawing.restored();
      }),
    ];
  }

  get sink(): SplatSink {
    return this.#splats.sink;
  }

  bound(manifest: Manifest): void {
    this.instance.bound(manifest);
  }

  picture(camera: CameraComponent): HostPicture | null {
    const device = this.#device;
    if (device.gl.isContextLost()) return null;
    if (this.app.xr?.active) throw new Error("headsets show no splats of this HgsScene: see @hgs/player/three");
    const { renderTarget } = device;
    const { width, height } = renderTarget ?? device;
    if (renderTarget && renderTarget.colorBufferCount > 1) {
      throw new Error(
        `the render target has ${renderTarget.colorBufferCount} textures: splats are drawn into one only`,
      );
    }
    if (renderTarget?.flipY) throw new Error("the render target is upside down: splats need one without flipY");
    const { x, y, z, w } = camera.rect;
    return {
      viewport: {
        x: Math.floor(x * width),
        y: Math.floor(y * height),
        width: Math.floor(z * width),
        height: Math.floor(w * height),
      },
      name: camera.entity.name,
      // Those of the meshes in this picture, with the jitter of antialiasing and the application's own changes.
      projection: this.#uniform("matrix_projection"),
      modelView: new Mat4().mul2(new Mat4().set([...this.#uniform("matrix_view")]), this.entity.getWorldTransform())
        .data,
      near: camera.nearClip,
    };
  }

  prepare(): Parameters<SplatSink["setOrder"]> | null {
    return this.#splats.prepare(this.#device.gl);
  }

  setOrder(...order: Parameters<SplatSink["setOrder"]>): void {
    this.#splats.setOrder(...order);
  }

  draw(camera: CameraComponent, viewport: Viewport, shot: Shot, depth: HostDepth): void {
    const target = this.#device.renderTarget;
    const converted = target?.isColorBufferSrgb(0); // the device's part
    const linear = this.linear ?? (converted || camera.gammaCorrection !== GAMMA_SRGB);
    const surface = { ...depth, logarithmic: 0, reversed: false, linear, exponent: converted ? 0 : EXPONENT };
    this.#splats.draw(viewport, shot, surface, FINE.get(target?.getColorBuffer(0)?.format) ?? null);
  }

  /** Delete the contents of the context, which stays the host's. The instance is its entity's to destroy. */
  dispose(): void {
    for (const listening of this.#listening) listening.off();
    this.#splats.dispose();
  }

  #uniform(name: string): Float32Array {
    return this.#device.scope.resolve(name).value;
  }
}

function webgl2(device: GraphicsDevice): WebglGraphicsDevice {
  if (device.isWebGL2) return device as WebglGraphicsDevice;
  throw new Error(
    `this application draws by ${device.deviceType}: splats need a device made of deviceTypes: ["webgl2"]`,
  );
}
