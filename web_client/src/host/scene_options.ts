/** Options and events of an `HgsScene`, in any host. */

import type { Beginning, HgsPlayerEvents, PlayingOptions, SoundOptions } from "../player/hgs_player_events";
import type { OpenSource } from "../source/scene_source";

export interface HgsSceneOptions extends PlayingOptions, SoundOptions, Pick<Beginning, "time"> {
  /** Address of the scene (see `openSource`), or a source. */
  readonly src: string | OpenSource;
  /**
   * Whether to write colours in linear light, for a later conversion to sRGB. Undefined or null for the choice of the
   * host's own materials.
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
