/** What an `HgsScene` is made from and what it tells. */

import type { Object3DEventMap } from "three";
import type { Beginning, HgsPlayerEvents, PlayingOptions, SoundOptions } from "../player/hgs_player_events";
import type { OpenSource } from "../source/scene_source";

export interface HgsSceneOptions extends PlayingOptions, SoundOptions, Pick<Beginning, "time"> {
  /** Where the scene is (see `openSource`), or a source of one's own. */
  readonly src: string | OpenSource;
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
  | "volumechange"
  | "error";

export type HgsSceneEvents = Pick<HgsPlayerEvents, Told> & {
  /** The next picture will be another one: for hosts that draw on demand. Ask for a frame; do not draw in the listener. */
  change: null;
};

/** By name, as three.js' listeners get them: `detail` is what stands in `HgsSceneEvents`. */
export type HgsSceneEventMap = Object3DEventMap & {
  readonly [K in keyof HgsSceneEvents]: { readonly detail: HgsSceneEvents[K] };
};
