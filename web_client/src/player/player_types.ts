/** What a player is made from and what it tells of itself. */

import type { Manifest } from "../codec/types";
import type { StreamState } from "../protocol/stream";
import type { View } from "./view";

export interface PlayerOptions {
  readonly canvas: HTMLCanvasElement;
  readonly streamUrl: string;
  /** Seconds from which to show and load first. */
  readonly time: number | null;
  readonly playing: boolean;
  /** Whether to draw with antialiasing; null to do as the scene's manifest says. */
  readonly antialiased: boolean | null;
  /** From where the scene is seen now; asked at every frame. Null while that is not known. */
  readonly view: () => View | null;
  readonly onManifest: (manifest: Manifest) => void;
  /** One line for people; playing may go on. */
  readonly onError: (message: string) => void;
}

export interface PlayerStats {
  readonly stream: StreamState;
  readonly bytes: number;
  readonly bytesTotal: number;
  readonly splats: number;
  readonly dynamicSplats: number;
  /** Chunks that the server cannot give, or not undamaged; the scene is shown without them. */
  readonly lostChunks: number;
  readonly framesPerSecond: number;
  /** Milliseconds from opening the page to the first picture; null before. */
  readonly firstFrame: number | null;
}
