/** The events and options of a player. */

import type { Manifest } from "../codec/types";
import type { Quality } from "../renderer/fineness";
import type { Viewing, ViewpointOptions } from "./viewpoint";

/** The first view of a scene. */
export interface Beginning {
  /** Seconds on the scene's clock; undefined for the scene's start. */
  readonly time?: number | null;
  /** Name of the capture camera; undefined for the first. */
  readonly camera?: string | null;
  /** Position of the camera; undefined for that of the capture camera. */
  readonly view?: Viewing | null;
  /** The stretch of time to repeat; see `HgsPlayer.loopRange`. */
  readonly loopRange?: readonly [number, number] | null;
}

/** Options of playing. */
export interface PlayingOptions {
  /** Whether to play at once; default false. */
  readonly autoplay?: boolean;
  /** Whether to begin again at the end; default false. */
  readonly loop?: boolean;
  /** Scene seconds per second, above 0 and at most 16; default 1. */
  readonly playbackRate?: number;
  /** Whether to fade splats thinner than a pixel; the default is the scene's own setting. */
  readonly antialiased?: boolean | null;
  /** Bytes for the scene's splats; default 384 MiB, and 192 MiB on phones. Beyond that, chunks are evicted. */
  readonly memoryBudget?: number;
  /** Largest number of splats drawn, the most useful ones; at least 1. Default all. */
  readonly splatBudget?: number;
  /** Whether to draw only moving splats; the default is the scene's own choice. */
  readonly subjectOnly?: boolean | null;
}

/** Options of a scene's sound. */
export interface SoundOptions {
  /** Whether it is muted; default false. */
  readonly muted?: boolean;
  /** Loudness, from 0 to 1; default 1. */
  readonly volume?: number;
}

export interface HgsPlayerOptions
  extends Beginning,
    PlayingOptions,
    SoundOptions,
    Partial<Omit<ViewpointOptions, "camera">> {
  /** Fineness of pictures; default `auto`. */
  readonly quality?: Quality;
}

/** A problem: one line for people, and the cause for debugging. Playing may continue. */
export interface PlayerProblem {
  readonly message: string;
  readonly cause: string;
}

/** The events of a player, with the types of their `detail`. */
export interface HgsPlayerEvents {
  /** A scene is being loaded; nothing is known about it yet. */
  loadstart: null;
  /** The scene's manifest has arrived, with its length and cameras. */
  manifest: Manifest;
  /** The first picture of the scene has been drawn. */
  firstpicture: null;
  /** Everything visible at the first time has been drawn. */
  ready: null;
  play: null;
  pause: null;
  /** The playhead waits for data. */
  stalled: null;
  /** The playhead continues after waiting. */
  playing: null;
  /** The playhead has moved; four times a second while it runs. */
  timeupdate: null;
  /** Everything visible at the target of a seek has been drawn. */
  seeked: null;
  /** The end is reached, and the scene does not repeat. */
  ended: null;
  ratechange: null;
  /** Volume or muting has changed; also once when the scene's sound is ready. */
  volumechange: null;
  /** The camera has moved, or the picture has another size. */
  viewchange: null;
  error: PlayerProblem;
  /** A frame has passed: anything may have changed. There are none while nothing happens. */
  frame: null;
}

/** The event of that name, for listeners. */
export type HgsPlayerEvent<K extends keyof HgsPlayerEvents> = CustomEvent<HgsPlayerEvents[K]>;

/** Typed listeners of the events. */
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
