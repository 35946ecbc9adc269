/** Sources of scenes: the interface between the player and a stream, a server or a folder of files. */

import type { Manifest } from "../codec/types";

/**
 * Reasons for a source's end: no such scene; a key or link required; the given one no longer valid; another scene than
 * before; an unreadable scene; different versions of page and server; a missing script of the source; anything else.
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

/**
 * `over-http`: open, but by HTTP, because the stream does not get through. `restarting`: the server has said that it
 * stops, and is awaited.
 */
export type SourceState = "connecting" | "open" | "over-http" | "retrying" | "restarting" | "closed";

/** Events of a source. */
export interface SourceEvents {
  /** The manifest, with the pages received so far; once. */
  manifest(manifest: Manifest): void;
  /** A later manifest, with further pages or additions to the scene. */
  grown(manifest: Manifest): void;
  /** A complete chunk; call `consumed` with its size once it is decoded. */
  chunk(id: string, bytes: Uint8Array<ArrayBuffer>): void;
  /** A chunk that is not available now; it may arrive later. */
  missing(id: string): void;
  /** Number of chunk bytes that have arrived. */
  progress(bytes: number): void;
  state(state: SourceState): void;
  /** The source has ended, and retrying would not help; `detail` is for debugging. */
  failed(failure: SourceFailure, detail: string): void;
}

/** The playhead of a source. */
export interface Playhead {
  /** Seconds; null for the scene's start. */
  readonly time: number | null;
  /** Scene seconds per second; 0 while paused. */
  readonly rate: number;
}

/** A source of a scene: brings the manifest and then the chunks, in the order in which the playhead needs them. */
export interface SceneSource {
  play(time: number, rate: number): void;
  pause(time: number): void;
  seek(time: number): void;
  /** Note the playhead's place, without a change of its course. */
  playheadAt(time: number): void;
  /** Report that a complete chunk of this size has been decoded. */
  consumed(bytes: number): void;
  /**
   * Bring a chunk's bytes once more, also after `close`: from a cache, or around all caches, which may hold a damaged
   * copy.
   *
   * @throws Error with one line for people
   */
  fetchAgain(id: string, signal: AbortSignal, cache?: "reload" | "default"): Promise<Uint8Array<ArrayBuffer>>;
  /** The network or the page is back: try now. */
  wake(): void;
  /** Close for good. */
  close(): void;
}

/** The first byte of an index as it is stored: gzip's. A manifest is plain JSON. */
export const GZIP = 0x1f;

/** A function that opens a source, which starts at once. */
export type OpenSource = (events: SourceEvents, playhead: Playhead) => SceneSource;

/** A scene's manifest: complete, or with the pages received so far. */
export interface SceneManifest {
  /** The manifest so far. A slice with one chunk, the page itself, stands for a missing page. */
  readonly manifest: Manifest;
  /** For a manifest in pages: their starts and numbers of segments. */
  readonly places?: readonly (readonly [number, number])[];
  /** Whether this is a page that has not arrived. */
  lacks?(id: string): boolean;
  /** Add a missing page; resolves to false if it is none. Rejects with ManifestError if it is damaged. */
  add?(id: string, bytes: Uint8Array<ArrayBuffer>): Promise<boolean>;
  /** The final pages received so far, with the ids of the chunks and of the sound that they list. */
  listed?(): [string, string[]][];
}
