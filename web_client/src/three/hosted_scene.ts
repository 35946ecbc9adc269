/** A scene that streams and plays inside a host's scene of three.js, with either of its renderers. See docs/three.md. */

import { Object3D, type Object3DEventMap, type PerspectiveCamera } from "three";
import { capturePlace } from "../host/host_view";
import { withHostedApi } from "../host/hosted_api";
import { HostedStream } from "../host/hosted_stream";
import type { HgsSceneEvents, HgsSceneOptions } from "../host/scene_options";
import { placeCamera } from "./three_camera";
import type { ThreeDrawer, ThreeDrawing, ThreeTurn } from "./three_drawer";

/** The events for three.js' listeners: `detail` is the type in `HgsSceneEvents`. */
export type HgsSceneEventMap = Object3DEventMap & {
  readonly [K in keyof HgsSceneEvents]: { readonly detail: HgsSceneEvents[K] };
};

/**
 * One scene of moving splats, an object with the scene's own space: its position, its quaternion and one scale for all axes
 * place it in the host's world. Times are seconds on the scene's clock, which runs from `start` to `end` while the host draws.
 */
export abstract class HostedScene<Renderer> extends withHostedApi(Object3D<HgsSceneEventMap>) {
  override readonly type: string = "HgsScene";
  /** @internal */
  protected readonly hosted: HostedStream<ThreeTurn<Renderer>>;

  /**
   * Create a scene.
   *
   * @internal
   * @param make the drawer for the host's kind of renderer.
   * @throws Error with one line for people if the address cannot be a scene's.
   * @throws RangeError if `playbackRate` is not in (0, 16], or `splatBudget` not at least 1.
   */
  constructor(options: HgsSceneOptions, make: (drawing: ThreeDrawing<Renderer>) => ThreeDrawer<Renderer>) {
    super();
    const object = { begin: () => this.begin(), emit: this.emit.bind(this) };
    this.hosted = new HostedStream(options, object, ({ draw, restored }) => {
      const drawer = make({
        restored,
        draw: (renderer, camera) => draw({ renderer, camera, world: this.matrixWorld }),
      });
      this.add(drawer.object);
      return drawer;
    });
  }

  /**
   * Move a camera to a capture camera, with a field of view that contains its whole picture.
   *
   * @param name of the capture camera; the first if undefined.
   * @throws Error if the manifest has not arrived, or has no camera of that name.
   */
  lookFrom(camera: PerspectiveCamera, name: string | null = null): void {
    const place = capturePlace(this.manifest, name, camera.aspect);
    this.updateWorldMatrix(true, false);
    placeCamera(camera, this.matrixWorld, place);
  }

  /** Stop for good and release everything but the host's context. */
  override dispose(): void {
    super.dispose();
    this.removeFromParent();
    this.hosted.dispose();
  }

  override copy(): never {
    throw new Error("an HgsScene cannot be copied or cloned: make another one of the same src");
  }

  protected override emit<K extends keyof HgsSceneEvents>(type: K, detail: HgsSceneEvents[K]): void {
    (this.dispatchEvent as (event: { type: K; detail: HgsSceneEvents[K] }) => void).call(this, { type, detail });
  }
}
