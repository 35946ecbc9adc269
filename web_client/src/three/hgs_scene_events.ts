/** Options and events of an `HgsScene`. */

import type { Object3DEventMap } from "three";
import type { Beginning, HgsPlayerEvents, PlayingOptions, SoundOptions } from "../player/hgs_player_events";
import type { OpenSource } from "../source/scene_source";

export interface HgsSceneOptions extends PlayingOptions, SoundOptions, Pick<Beginning, "time"> {
  /** Address of the scene (see `openSource`), or a source. */
  readonly src: string | OpenSource;
  /**
   * Whether to write colours in linear light, for a later conversion to sRGB. Undefined or null for the choice of
   * three.js' own materials: by the renderer's `outputColorSpace` on its canvas, and linear light to render targets.
   */
  readonly linear?: boolean | null;
}

/** The events of a player that a scene has, too. */
type SharedEvent =
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

export type HgsSceneEvents = Pick<HgsPlayerEvents, SharedEvent> & {
  /** The next picture will differ: for hosts that draw on demand. Request a frame; do not draw in the listener. */
  change: null;
};

/** The events for three.js' listeners: `detail` is the type in `HgsSceneEvents`. */
export type HgsSceneEventMap = Object3DEventMap & {
  readonly [K in keyof HgsSceneEvents]: { readonly detail: HgsSceneEvents[K] };
};
