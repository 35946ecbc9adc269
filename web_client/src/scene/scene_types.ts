/** Options, events and steps of a streamed scene. */

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
  /** Whether to draw with antialiasing; null for the manifest's choice. */
  readonly antialiased: boolean | null;
  /** Memory for the scene's splats, of page and device, bytes; the default is for the kind of device. */
  readonly memoryBudget?: number;
}

/** The result of a step. */
export interface SceneStep {
  /** The shots for the views; none before the first order. */
  readonly shots: readonly Shot[];
  /** Whether the scene moves, and is not waiting for data. */
  readonly moving: boolean;
  /** Whether the shots contain all splats alive at their time. */
  readonly settled: boolean;
}

export interface SceneEvents {
  manifest(manifest: Manifest): void;
  /** The manifest has become a later version. */
  grown?(manifest: Manifest): void;
  /** A change that the next frame should consider. */
  changed(): void;
  /** The sink has a new order. */
  ordered(): void;
  /** One line for people, and the cause for debugging; playing may continue. */
  failed(message: string, cause: string): void;
}
