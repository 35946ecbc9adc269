/** Options and statistics of a scene on a canvas. */

import type { Manifest } from "../codec/types";
import type { Fineness } from "../renderer/fineness";
import type { View } from "../scene/view";
import type { OpenSource, SourceState } from "../source/scene_source";

export interface PlayerOptions {
  readonly canvas: HTMLCanvasElement;
  readonly source: OpenSource;
  /** Seconds from which to show and load first. */
  readonly time: number | null;
  readonly playing: boolean;
  /** Whether to draw with antialiasing; null for the manifest's choice. */
  readonly antialiased: boolean | null;
  /** Bytes for the scene's splats; default 384 MiB, and 192 MiB on phones. Beyond that, chunks are evicted. */
  readonly memoryBudget?: number;
  /** The current view, requested at every frame; null while it is unknown. Report changes to `invalidate`. */
  readonly view: () => View | null;
  readonly onManifest: (manifest: Manifest) => void;
  /** Called at the end of every frame, and so after every change of the statistics. */
  readonly onFrame: () => void;
  /** One line for people, and the cause for debugging; playing may continue. */
  readonly onError: (message: string, cause: string) => void;
}

export interface PlayerStats {
  readonly stream: SourceState;
  readonly bytes: number;
  readonly bytesTotal: number;
  /** Rate of the line, bytes per second; 0 after two seconds without data. */
  readonly lineRate: number;
  /** Chunks decoded. */
  readonly chunks: number;
  /** Chunks that the server cannot send, or only damaged; the scene is shown without them. */
  readonly lostChunks: number;
  /** True once the whole scene has arrived. */
  readonly complete: boolean;
  /** Whether the playhead waits for the scene to grow. */
  readonly atEdge: boolean;
  readonly splats: number;
  readonly dynamicSplats: number;
  /** 0 while nothing is drawn. */
  readonly framesPerSecond: number;
  readonly framesDrawn: number;
  /** Frames of the browser that brought no new picture while the scene played. */
  readonly framesDropped: number;
  /** Duration of the shown order's sort in the worker, milliseconds. */
  readonly sortTime: number;
  /** Time from the request of that order to the last frame, milliseconds; and in frames, ideally 1. */
  readonly orderAge: number;
  readonly orderAgeFrames: number;
  /** The scene's time of the picture, seconds: the playhead's, or as near to it as the order allows. */
  readonly pictureTime: number;
  /** Fineness of the last picture. */
  readonly fineness: Fineness;
  /** True while the browser has taken the graphics device away. */
  readonly contextLost: boolean;
  /** True while the scene is paused because too many others of the page play. */
  readonly setAside: boolean;
  /** Milliseconds from opening the page to the first picture; null before. */
  readonly firstFrame: number | null;
  /** Milliseconds from opening the page to the start of loading. */
  readonly loadStart: number;
}
