/** `@hgs/player/playcanvas`: a scene among the meshes of a PlayCanvas application. See docs/three.md. */

import { type AppBase, type CameraComponent, Entity, Mat4, Quat } from "playcanvas";
import { capturePlace } from "../host/host_view";
import { withHostedApi } from "../host/hosted_api";
import { HostedStream } from "../host/hosted_stream";
import type { HgsSceneEvents, HgsSceneOptions } from "../host/scene_options";
import { EntitySplats } from "./entity_splats";

export type { HgsSceneEvents, HgsSceneOptions };

/**
 * One scene of moving splats, an entity with the scene's own space: its position, its rotation and one scale for all axes
 * place it in the application's world. Times are seconds on the scene's clock, which runs from `start` to `end` while
 * the application draws.
 *
 * @example
 * const scene = new HgsScene(app, { src: "studio/manifest.json", loop: true, autoplay: true });
 * app.root.addChild(scene);
 */
export class HgsScene extends withHostedApi(Entity) {
  /** @internal */
  protected readonly hosted: HostedStream<CameraComponent>;

  /**
   * Create a scene.
   *
   * @throws Error with one line for people if the address cannot be a scene's, or the application cannot draw it.
   * @throws RangeError if `playbackRate` is not in (0, 16], or `splatBudget` not at least 1.
   */
  constructor(app: AppBase, options: HgsSceneOptions) {
    super("HgsScene", app);
    const render = this.addComponent("render");
    if (!render) throw new Error("this application draws no meshes: create it with a RenderComponentSystem");
    const object = { begin: () => this.begin(), emit: this.emit.bind(this) };
    this.hosted = new HostedStream(options, object, (drawing) => {
      const splats = new EntitySplats(app, this, options.linear ?? null, drawing);
      Object.assign(render, { castShadows: false, meshInstances: [splats.instance] });
      return splats;
    });
  }

  /**
   * Move a camera to a capture camera, with a field of view that contains its whole picture.
   *
   * @param name of the capture camera; the first if undefined.
   * @throws Error if the manifest has not arrived, or has no camera of that name.
   */
  lookFrom(camera: CameraComponent, name: string | null = null): void {
    const { matrix, fov } = capturePlace(this.manifest, name, camera.aspectRatio);
    const placed = new Mat4().mul2(this.getWorldTransform(), new Mat4().set([...matrix]));
    camera.entity.setPosition(placed.getTranslation());
    camera.entity.setRotation(new Quat().setFromMat4(placed));
    camera.horizontalFov = false;
    camera.fov = fov;
  }

  /** Stop for good and release everything but the application's device. */
  override destroy(): void {
    super.destroy();
    this.hosted.dispose();
  }

  override clone(): never {
    throw new Error("an HgsScene cannot be cloned: make another one of the same src");
  }

  protected override emit<K extends keyof HgsSceneEvents>(type: K, detail: HgsSceneEvents[K]): void {
    this.fire(type, detail);
  }
}
