/** What a streamed scene is made from, what it tells of itself, and what a step of it comes to. */

import type { Manifest } from "../codec/types";
import type { Shot } from "../renderer/shot";
import type { SplatSink } from "../renderer/splat_drawer";
import type { OpenSource } from "../source/scene_source";

export interface SceneOptions {
  readonly open: OpenSource;
  readonly sink: SplatSink;
  /** Seconds from which to show and load first; null for the start. */
  readonly time: number | null;
  readonly playing: boolean;
  /** Whether to draw with antialiasing; null to do as the scene's manifest says. */
  readonly antialiased: boolean | null;
  /** Bytes that the scene's splats may take, of this page and of the device; by the kind of device if not given. */
  readonly memoryBudget?: number;
}

/** What a step has come to. */
export interface SceneStep {
  /** What to draw for each of the views; none before the first order. */
  readonly shots: readonly Shot[];
  /** Whether the scene moves, and is not waiting for data. */
  readonly moving: boolean;
  /** Whether all that is alive at the time of the shots is in them. */
  readonly settled: boolean;
}

export interface SceneEvents {
  manifest(manifest: Manifest): void;
  /** The manifest has become a later version. */
  grown?(manifest: Manifest): void;
  /** Something has changed that the next frame should look at. */
  changed(): void;
  /** The sink has a new order. */
  ordered(): void;
  /** One line for people, and the cause for whoever looks into it; playing may go on. */
  failed(message: string, cause: string): void;
}
