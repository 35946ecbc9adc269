/** Attributes, properties and listeners of `<hgs-player>` in the templates of any framework. */

import type { HgsPlayerEvent, HgsPlayerEvents } from "../player/hgs_player_events";
import type { HgsPlayerElement } from "./player_element";

/** Attributes of the element, and properties that a template may set. */
export interface HgsPlayerAttributes
  extends Partial<
    Pick<
      HgsPlayerElement,
      "src" | "poster" | "autoplay" | "controls" | "loop" | "muted" | "volume" | "currentTime" | "playbackRate"
    >
  > {
  /** Seconds on the scene's clock to begin with. */
  time?: number | string;
  /** Name of the capture camera to begin with. */
  camera?: string;
  /** Whether only moving splats are drawn; null for the scene's own choice. */
  subjectOnly?: boolean | null;
  /** The same as an attribute, `"false"` for all splats. */
  "subject-only"?: boolean | string;
}

/** Events that the element repeats: all of its player's but `frame`. */
export type HgsPlayerElementEvent = Exclude<keyof HgsPlayerEvents, "frame">;

/** Listeners as React and Svelte name them: `onready`. */
export type HgsPlayerListeners = {
  [K in HgsPlayerElementEvent as `on${K}`]?: (event: HgsPlayerEvent<K>) => void;
};

/** Listeners as Vue names those of `@ready`: `onReady`. */
export type CapitalisedListeners = {
  [K in HgsPlayerElementEvent as `on${Capitalize<K>}`]?: (event: HgsPlayerEvent<K>) => void;
};
