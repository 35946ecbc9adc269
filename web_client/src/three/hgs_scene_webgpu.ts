/** `@hgs/player/three-webgpu`: a scene among meshes that three.js' `WebGPURenderer` draws. See docs/three.md. */

import type { WebGPURenderer } from "three/webgpu";
import type { HgsSceneEvents, HgsSceneOptions } from "../host/scene_options";
import { type HgsSceneEventMap, HostedScene } from "./hosted_scene";
import { NodeSplats } from "./node_splats";

export type { HgsSceneEventMap, HgsSceneEvents, HgsSceneOptions };

/**
 * One scene of moving splats, by WebGPU, or by WebGL2 where the renderer has fallen back to it.
 *
 * @example
 * const scene = new HgsScene({ src: "studio/manifest.json", loop: true, autoplay: true });
 * threeScene.add(scene);
 */
export class HgsScene extends HostedScene<WebGPURenderer> {
  /**
   * Create a scene.
   *
   * @throws Error with one line for people if the address cannot be a scene's.
   * @throws RangeError if `playbackRate` is not in (0, 16], or `splatBudget` not at least 1.
   */
  constructor(options: HgsSceneOptions) {
    super(options, (drawing) => new NodeSplats(options.linear ?? true, drawing));
  }
}
