/** What an `HgsScene` is made from and what it tells. */

import type { Object3DEventMap } from "three";
import type { HgsPlayerEvents } from "../player/hgs_player_events";
import type { OpenSource } from "../source/scene_source";

export interface HgsSceneOptions {
  /** Where the scene is (see `openSource`), or a source of one's own. */
  readonly src: string | OpenSource;
  /** Seconds on the scene's clock; the scene's start if left out. */
  readonly time?: number | null;
  /** Whether to play at once; false if left out. */
  readonly autoplay?: boolean;
  /** Whether to begin again at the end; false if left out. */
  readonly loop?: boolean;
  /** Scene seconds per second, above 0 and at most 16; 1 if left out. */
  readonly playbackRate?: number;
  /** Whether to fade splats thinner than a pixel; as the scene asks for if left out. */
  readonly antialiased?: boolean | null;
  /** Bytes that the scene's splats may take; by default 384 MiB, and 192 MiB on phones. What is passed makes room. */
  readonly memoryBudget?: number;
  /**
   * Whether to write colours in linear light, for what turns them into sRGB later. Left out or null: as three.js' own
   * materials do, by the renderer's `outputColorSpace` on its canvas, and in linear light to render targets.
   */
  readonly linear?: boolean | null;
}

/** Those of a player's events that a scene tells, too. */
type Told =
  | "manifest"
  | "firstpicture"
  | "ready"
  | "play"
  | "pause"
  | "stalled"
  | "playing"
  | "timeupdate"
  | "seeked"
  | "ended"
  | "ratechange"
  | "error";

export type HgsSceneEvents = Pick<HgsPlayerEvents, Told> & {
  /** The next picture will be another one: for hosts that draw on demand. Ask for a frame; do not draw in the listener. */
  change: null;
};

/** By name, as three.js' listeners get them: `detail` is what stands in `HgsSceneEvents`. */
export type HgsSceneEventMap = Object3DEventMap & {
  readonly [K in keyof HgsSceneEvents]: { readonly detail: HgsSceneEvents[K] };
};
