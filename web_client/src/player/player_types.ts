/** What a player is made from and what it tells of itself. */

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
  /** Whether to draw with antialiasing; null to do as the scene's manifest says. */
  readonly antialiased: boolean | null;
  /** Bytes that the scene's splats may take; by default 384 MiB, and 192 MiB on phones. What is passed makes room. */
  readonly memoryBudget?: number;
  /** From where the scene is seen now; asked at every frame. Null while that is not known. Tell changes to `invalidate`. */
  readonly view: () => View | null;
  readonly onManifest: (manifest: Manifest) => void;
  /** Called at the end of every frame, and so after every change of what the player tells of itself. */
  readonly onFrame: () => void;
  /** One line for people, and the cause for whoever looks into it; playing may go on. */
  readonly onError: (message: string, cause: string) => void;
}

export interface PlayerStats {
  readonly stream: SourceState;
  readonly bytes: number;
  readonly bytesTotal: number;
  /** Bytes per second that the line brings; 0 when nothing has come for two seconds. */
  readonly lineRate: number;
  /** Chunks decoded. */
  readonly chunks: number;
  /** Chunks that the server cannot give, or not undamaged; the scene is shown without them. */
  readonly lostChunks: number;
  /** True once the whole scene is here. */
  readonly complete: boolean;
  /** Whether the playhead waits for the scene to grow. */
  readonly atEdge: boolean;
  readonly splats: number;
  readonly dynamicSplats: number;
  /** 0 while nothing has to be drawn. */
  readonly framesPerSecond: number;
  readonly framesDrawn: number;
  /** Frames that the browser offered while the scene played, and for which no new picture was ready. */
  readonly framesDropped: number;
  /** How long the worker needed for the order that is shown, milliseconds. */
  readonly sortTime: number;
  /** How long before the last frame that order had been asked for, milliseconds; and in frames, 1 while all goes well. */
  readonly orderAge: number;
  readonly orderAgeFrames: number;
  /** The scene's time that the picture shows, seconds: the playhead's, or as near to it as its order allows. */
  readonly pictureTime: number;
  /** How finely the last picture was drawn. */
  readonly fineness: Fineness;
  /** True while the browser has taken the graphics device away. */
  readonly contextLost: boolean;
  /** True while the scene was made to stand because so many others of the page play. */
  readonly setAside: boolean;
  /** Milliseconds from opening the page to the first picture; null before. */
  readonly firstFrame: number | null;
  /** Milliseconds from opening the page until the scene began to be loaded. */
  readonly loadStart: number;
}
