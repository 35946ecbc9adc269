/** One scene in an element of a page: its canvas, its player and its viewpoint, until another scene is loaded. */

import type { Manifest } from "../codec/types";
import type { PlayerClock } from "../scene/clock";
import { ProgressEvents } from "../scene/playback";
import type { OpenSource } from "../source/scene_source";
import type { HgsPlayerEvents } from "./hgs_player_events";
import { SceneCanvas } from "./scene_canvas";
import { Viewpoint, type ViewpointOptions } from "./viewpoint";

export interface MountedSceneOptions {
  readonly open: OpenSource;
  /** Seconds; null for the start. */
  readonly time: number | null;
  readonly playing: boolean;
  readonly antialiased: boolean | null;
  readonly memoryBudget?: number;
  readonly viewpoint: ViewpointOptions;
}

type Emit = <K extends keyof HgsPlayerEvents>(type: K, detail: HgsPlayerEvents[K]) => void;

export class MountedScene {
  readonly canvas = document.createElement("canvas");
  readonly viewpoint: Viewpoint;
  readonly player: SceneCanvas;
  manifest: Manifest | null = null;
  readonly #abort = new AbortController();
  readonly #progress = new ProgressEvents();
  readonly #failed: Promise<never>;
  #fail: (error: Error) => void = () => {};

  /**
   * Mount a scene.
   *
   * @throws Error if the browser has no WebGL2.
   */
  constructor(
    stage: HTMLElement,
    { open, time, playing, antialiased, memoryBudget, viewpoint }: MountedSceneOptions,
    readonly emit: Emit,
  ) {
    this.#failed = new Promise((_, reject) => {
      this.#fail = reject;
    });
    this.#failed.catch(() => {}); // callers of settled() handle it, all others the event
    const { signal } = this.#abort;
    const { canvas } = this;
    Object.assign(canvas.style, { position: "absolute", inset: "0", width: "100%", height: "100%", display: "block" });
    stage.append(canvas);
    signal.addEventListener("abort", () => canvas.remove());
    const events = {
      changed: () => {
        this.player?.invalidate();
        emit("viewchange", null);
      },
      scene: () => this.player,
    };
    this.viewpoint = new Viewpoint(canvas, viewpoint, events, signal);
    try {
      this.player = new SceneCanvas({
        canvas,
        source: open,
        time,
        playing,
        antialiased,
        memoryBudget,
        view: () => this.viewpoint.view(),
        onManifest: (manifest) => {
          this.viewpoint.begin(manifest);
          this.manifest = manifest;
          emit("manifest", manifest);
        },
        onFrame: () => this.#frame(),
        onError: (message, cause) => {
          this.#fail(new Error(cause));
          emit("error", { message, cause });
        },
      });
    } catch (error) {
      this.#abort.abort();
      throw error;
    }
  }

  get clock(): PlayerClock | null {
    return this.player.playback?.clock ?? null;
  }

  /** Fulfilled when everything visible at the playhead is drawn; rejected on failure. */
  settled(): Promise<void> {
    return Promise.race([this.player.settled(), this.#failed]);
  }

  /** Signal that aborts when the scene is removed. */
  get gone(): AbortSignal {
    return this.#abort.signal;
  }

  dispose(): void {
    this.#abort.abort();
    this.player.dispose();
    this.#fail(new DOMException("the scene has been removed", "AbortError"));
  }

  #frame(): void {
    const { clock, player } = this;
    if (clock) {
      const pictured = player.stats.firstFrame !== null;
      for (const type of this.#progress.since(clock, pictured, performance.now())) this.emit(type, null);
    }
    this.emit("frame", null);
  }
}
