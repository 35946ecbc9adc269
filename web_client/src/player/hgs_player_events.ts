/** What a player tells a page, and what a page may ask of it. */

import type { Manifest } from "../codec/types";
import type { Quality } from "../renderer/fineness";
import type { Viewing, ViewpointOptions } from "./viewpoint";

/** What of a scene is seen first. */
export interface Beginning {
  /** Seconds on the scene's clock; the scene's start if left out. */
  readonly time?: number | null;
  /** Name of the capture camera; the first if left out. */
  readonly camera?: string | null;
  /** Where the camera stands; as the capture camera if left out. */
  readonly view?: Viewing | null;
  /** The stretch of time to repeat; see `HgsPlayer.loopRange`. */
  readonly loopRange?: readonly [number, number] | null;
}

/** How a scene plays. */
export interface PlayingOptions {
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
  /** So many splats are drawn at most, the most useful ones; at least 1. As many as there are if left out. */
  readonly splatBudget?: number;
}

/** How a scene sounds that has sound. */
export interface SoundOptions {
  /** Whether it is silent; false if left out. */
  readonly muted?: boolean;
  /** How loud, from 0 to 1; 1 if left out. */
  readonly volume?: number;
}

export interface HgsPlayerOptions
  extends Beginning,
    PlayingOptions,
    SoundOptions,
    Partial<Omit<ViewpointOptions, "camera">> {
  /** How finely pictures are drawn; `auto` if left out. */
  readonly quality?: Quality;
}

/** What goes wrong: one line for people, and the cause for whoever looks into it. Playing may go on. */
export interface PlayerProblem {
  readonly message: string;
  readonly cause: string;
}

/** The events of a player; `detail` of each is what stands here. */
export interface HgsPlayerEvents {
  /** A scene is being loaded: nothing is known of it yet. */
  loadstart: null;
  /** The scene's description has come: its length, its cameras. */
  manifest: Manifest;
  /** The first picture of the scene has been drawn. */
  firstpicture: null;
  /** Everything that is to be seen at the time of loading has been drawn. */
  ready: null;
  play: null;
  pause: null;
  /** The playhead waits for data. */
  stalled: null;
  /** The playhead goes on after waiting. */
  playing: null;
  /** The playhead has moved; four times a second while it runs. */
  timeupdate: null;
  /** All of what is to be seen at the time that was sought has been drawn. */
  seeked: null;
  /** The end is reached, and the scene does not begin again. */
  ended: null;
  ratechange: null;
  /** It is louder, or quieter, or muted, or no more; and once when the sound of a scene that has any is there. */
  volumechange: null;
  /** The camera has moved, or the picture has another size. */
  viewchange: null;
  error: PlayerProblem;
  /** A frame has passed: anything may have changed. Only while there is something to do. */
  frame: null;
}

/** The event of that name, as its listeners get it. */
export type HgsPlayerEvent<K extends keyof HgsPlayerEvents> = CustomEvent<HgsPlayerEvents[K]>;

/** How a listener hears of an event by its name. */
export interface HgsPlayerListening {
  addEventListener<K extends keyof HgsPlayerEvents>(
    type: K,
    listener: (event: HgsPlayerEvent<K>) => void,
    options?: boolean | AddEventListenerOptions,
  ): void;
  removeEventListener<K extends keyof HgsPlayerEvents>(
    type: K,
    listener: (event: HgsPlayerEvent<K>) => void,
    options?: boolean | EventListenerOptions,
  ): void;
}
