/** Where a scene comes from: what a player needs of a stream, a server or a folder of files. */

import type { Manifest } from "../codec/types";

/**
 * The scene is not there; a key or link is needed; the one given is no longer valid; the scene is another one than before;
 * it cannot be read; page and server are of different versions; the source's own script cannot be had; anything else.
 */
export type SourceFailure =
  | "no-scene"
  | "no-access"
  | "access-ended"
  | "scene-changed"
  | "unreadable"
  | "not-understood"
  | "not-loaded"
  | "ended";

/** `over-http`: open, but by HTTP in place of the stream, which something on the way does not let through. */
export type SourceState = "connecting" | "open" | "over-http" | "retrying" | "closed";

/** What a source tells the player. */
export interface SourceEvents {
  /** The manifest, as far as its pages are here; once. */
  manifest(manifest: Manifest): void;
  /** More of the manifest is here, or the scene has grown: this is its manifest now. */
  grown(manifest: Manifest): void;
  /** A complete chunk; call `consumed` with its size when it is done with. */
  chunk(id: string, bytes: Uint8Array<ArrayBuffer>): void;
  /** A chunk that cannot be had now; it may come later. */
  missing(id: string): void;
  /** So many chunk bytes have arrived. */
  progress(bytes: number): void;
  state(state: SourceState): void;
  /** The source is done for a reason that trying again does not cure; `detail` is for whoever looks into it. */
  failed(failure: SourceFailure, detail: string): void;
}

/** Where the scene is shown. */
export interface Playhead {
  /** Seconds; null for the scene's start. */
  readonly time: number | null;
  /** Scene seconds per second; 0 while paused. */
  readonly rate: number;
}

/** Brings a scene's manifest and then its chunks, those first that the playhead needs first. */
export interface SceneSource {
  play(time: number, rate: number): void;
  pause(time: number): void;
  seek(time: number): void;
  /** Note where the playhead is, without a change of its course. */
  playheadAt(time: number): void;
  /** A complete chunk of so many bytes has been decoded. */
  consumed(bytes: number): void;
  /**
   * Bring a chunk's bytes once more, also after `close`: past every cache, in which a damaged copy may lie, or from one.
   *
   * @throws Error with one line for people
   */
  fetchAgain(id: string, signal: AbortSignal, cache?: "reload" | "default"): Promise<Uint8Array<ArrayBuffer>>;
  /** The network or the page is back: try now. */
  wake(): void;
  /** Leave for good. */
  close(): void;
}

/** The first byte of an index as it is stored: gzip's. A manifest is plain JSON. */
export const GZIP = 0x1f;

/** Opens a source, which begins to bring the scene at once. */
export type OpenSource = (events: SourceEvents, playhead: Playhead) => SceneSource;

/** A scene's manifest: all of a short one, and of a long one the pages that have come. */
export interface SceneManifest {
  /** As far as it is here. In place of a page that is not there is a slice with one chunk, which is the page. */
  readonly manifest: Manifest;
  /** Of a manifest in pages: where they begin, and how many segments each has. */
  readonly places?: readonly (readonly [number, number])[];
  /** Whether there is such a page, and it has not come. */
  lacks?(id: string): boolean;
  /** Take a page that is lacking; resolves to false if it is none. Rejects with ManifestError if it is damaged. */
  add?(id: string, bytes: Uint8Array<ArrayBuffer>): Promise<boolean>;
  /** The pages that have come and will not change, with the ids of the chunks and of the sound that they list. */
  listed?(): [string, string[]][];
}
