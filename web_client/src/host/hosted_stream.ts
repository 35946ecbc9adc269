/** A scene that streams, plays and is drawn in a host's pictures: the part that is the same in all hosts. */

import { stillShare } from "../camera/cones";
import type { Manifest } from "../codec/types";
import { type Asked, asked } from "../player/media_api";
import { checkedSplats } from "../renderer/fineness";
import { ProgressEvents } from "../scene/playback";
import { StreamedScene } from "../scene/streamed_scene";
import { openSource } from "../source/open_source";
import type { HostDrawer, HostDrawing } from "./host_drawer";
import { HostPictures } from "./host_pictures";
import { HostSound } from "./host_sound";
import type { HgsSceneEvents, HgsSceneOptions } from "./scene_options";

/** The object of the host's that stands for the scene. */
export interface HostObject {
  /** The manifest has arrived: apply the earlier requests. */
  begin(): void;
  emit<K extends keyof HgsSceneEvents>(type: K, detail: HgsSceneEvents[K]): void;
}

export class HostedStream<Turn> {
  readonly asked: Asked;
  readonly scene: StreamedScene;
  readonly sound: HostSound;
  readonly drawer: HostDrawer<Turn>;
  readonly #object: HostObject;
  readonly #pictures: HostPictures<Turn>;
  readonly #progress = new ProgressEvents();
  readonly #listeners = new AbortController();
  readonly #waiting: (() => void)[] = [];
  readonly #failed: Promise<never>;
  #fail: (error: Error) => void = () => {};
  #refused: string | null = null;

  /**
   * Open a scene.
   *
   * @param make the drawer for the kind of host.
   * @throws Error with one line for people if the address cannot be a scene's.
   * @throws RangeError if `playbackRate` is not in (0, 16], or `splatBudget` not at least 1.
   */
  constructor(options: HgsSceneOptions, object: HostObject, make: (drawing: HostDrawing<Turn>) => HostDrawer<Turn>) {
    const { src, antialiased = null } = options;
    this.#object = object;
    this.asked = asked(options);
    const { time, playing } = this.asked;
    const budget = checkedSplats(options.splatBudget ?? Number.POSITIVE_INFINITY);
    const open = typeof src === "string" ? openSource(src) : src;
    this.#failed = new Promise((_, reject) => {
      this.#fail = reject;
    });
    this.#failed.catch(() => {}); // callers of load() handle it, all others the event
    this.drawer = make({
      draw: (turn) => this.#draw(turn),
      restored: () => {
        this.#pictures.forget();
        this.scene.restore();
        object.emit("change", null);
      },
    });
    this.#pictures = new HostPictures(this.drawer, (settled) => this.#framed(settled));
    this.scene = new StreamedScene(
      { open, sink: this.drawer.sink, time, playing, antialiased, memoryBudget: options.memoryBudget },
      {
        grown: (manifest) => this.drawer.bound(manifest),
        manifest: (manifest) => this.#begin(manifest),
        changed: () => object.emit("change", null),
        ordered: () => object.emit("change", null),
        failed: (message, cause) => {
          this.#fail(new Error(cause));
          object.emit("error", { message, cause });
        },
      },
    );
    this.scene.splatBudget = budget;
    this.scene.subjectOnly = options.subjectOnly ?? null;
    const { signal } = this.#listeners;
    this.sound = new HostSound(options, this.scene, signal, {
      changed: () => object.emit("volumechange", null),
      failed: (problem) => object.emit("error", problem),
    });
    document.addEventListener("visibilitychange", () => this.#visibility(), { signal });
    addEventListener("online", () => this.scene.wake(), { signal });
    this.settled().then(
      () => object.emit("ready", null),
      () => {}, // reported by `error`, or intentional
    );
  }

  /** Fulfilled when everything visible at the playhead is drawn. */
  async settled(): Promise<boolean> {
    const settled = new Promise<void>((resolve) => this.#waiting.push(resolve));
    this.#object.emit("change", null);
    await Promise.race([settled, this.#failed]);
    return true;
  }

  /** Stop for good and release everything but the host's context. */
  dispose(): void {
    this.#listeners.abort();
    this.scene.dispose();
    this.drawer.dispose();
    this.#fail(new DOMException("the scene has been disposed of", "AbortError"));
  }

  #begin(manifest: Manifest): void {
    this.drawer.bound(manifest);
    this.scene.still = stillShare(manifest);
    this.#object.begin();
    this.#object.emit("manifest", manifest);
    if (manifest.audio) void this.sound.listen();
  }

  #draw(turn: Turn): void {
    if (this.#listeners.signal.aborted) return;
    try {
      this.#pictures.draw(this.scene, turn);
      this.#refused = null;
    } catch (error) {
      const cause = error instanceof Error ? error.message : String(error);
      if (cause === this.#refused) return; // reported once, not at every frame
      this.#refused = cause;
      // biome-ignore lint/suspicious/noConsole: the place where developers look for it
      console.warn(`HgsScene: ${cause}`);
      this.#object.emit("error", { message: cause, cause });
    }
  }

  #framed(settled: boolean): void {
    if (this.#listeners.signal.aborted) return;
    if (settled) for (const resolve of this.#waiting.splice(0)) resolve();
    const clock = this.scene.playback?.clock;
    if (!clock) return;
    this.sound.framed();
    for (const type of this.#progress.since(clock, this.scene.pictured, performance.now())) {
      if (type === "pause") this.asked.playing = false;
      this.#object.emit(type, null);
    }
    if (clock.playing) this.#object.emit("change", null);
  }

  /** The connection may have died while the page was hidden. */
  #visibility(): void {
    if (!document.hidden) this.scene.wake();
    this.scene.playback?.pageHidden(document.hidden);
  }
}
