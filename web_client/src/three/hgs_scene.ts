/** `@hgs/player/three`: a scene among meshes that three.js' `WebGLRenderer` draws. See docs/three.md. */

import type { WebGLRenderer } from "three";
import type { HgsSceneEvents, HgsSceneOptions } from "../host/scene_options";
import { type HgsSceneEventMap, HostedScene } from "./hosted_scene";
import { HostedSplats } from "./hosted_splats";

export type { HgsSceneEventMap, HgsSceneEvents, HgsSceneOptions };

/**
 * One scene of moving splats.
 *
 * @example
 * const scene = new HgsScene({ src: "studio/manifest.json", loop: true, autoplay: true });
 * threeScene.add(scene);
 */
export class HgsScene extends HostedScene<WebGLRenderer> {
  /**
   * Create a scene.
   *
   * @throws Error with one line for people if the address cannot be a scene's.
   * @throws RangeError if `playbackRate` is not in (0, 16], or `splatBudget` not at least 1.
   */
  constructor(options: HgsSceneOptions) {
    super(options, (drawing) => new HostedSplats(options.linear ?? null, drawing));
  }
}
