/** A scene that streams and plays inside a host's scene of three.js, with either of its renderers. See docs/three.md. */

import { type Camera, Object3D, type PerspectiveCamera } from "three";
import { stillShare } from "../camera/cones";
import type { Manifest } from "../codec/types";
import { type Asked, asked, withMediaApi } from "../player/media_api";
import { checkedSplats } from "../renderer/fineness";
import { type Playback, ProgressEvents } from "../scene/playback";
import { StreamedScene } from "../scene/streamed_scene";
import { openSource } from "../source/open_source";
import type { HgsSceneEventMap, HgsSceneEvents, HgsSceneOptions } from "./hgs_scene_events";
import type { HostDrawer, HostDrawing } from "./host_drawer";
import { HostPictures } from "./host_pictures";
import { HostSound } from "./host_sound";
import { lookFrom } from "./host_view";

/**
 * One scene of moving splats, an object with the scene's own space: its position, its quaternion and one scale for all axes
 * place it in the host's world. Times are seconds on the scene's clock, which runs from `start` to `end` while the host draws.
 */
export abstract class HostedScene<Renderer> extends withMediaApi(Object3D<HgsSceneEventMap>) {
  override readonly type: string = "HgsScene";
  protected readonly asked: Asked;
  readonly #drawer: HostDrawer<Renderer>;
  readonly #pictures: HostPictures<Renderer>;
  readonly #scene: StreamedScene;
  readonly #sound: HostSound;
  readonly #progress = new ProgressEvents();
  readonly #listeners = new AbortController();
  readonly #waiting: (() => void)[] = [];
  readonly #failed: Promise<never>;
  #fail: (error: Error) => void = () => {};
  #refused: string | null = null;

  /**
   * Create a scene.
   *
   * @internal
   * @param make the drawer for the host's kind of renderer.
   * @throws Error with one line for people if the address cannot be a scene's.
   * @throws RangeError if `playbackRate` is not in (0, 16], or `splatBudget` not at least 1.
   */
  constructor(options: HgsSceneOptions, make: (drawing: HostDrawing<Renderer>) => HostDrawer<Renderer>) {
    super();
    const { src, antialiased = null } = options;
    this.asked = asked(options);
    const { time, playing } = this.asked;
    this.#failed = new Promise((_, reject) => {
      this.#fail = reject;
    });
    this.#failed.catch(() => {}); // callers of load() handle it, all others the event
    this.#drawer = make({
      draw: (renderer, camera) => this.#draw(renderer, camera),
      restored: () => {
        this.#pictures.forget();
        this.#scene.restore();
        this.emit("change", null);
      },
    });
    this.add(this.#drawer.object);
    this.#pictures = new HostPictures(this.#drawer, (settled) => this.#framed(settled));
    this.#scene = new StreamedScene(
      {
        open: typeof src === "string" ? openSource(src) : src,
        sink: this.#drawer.sink,
        time,
        playing,
        antialiased,
        memoryBudget: options.memoryBudget,
      },
      {
        grown: (manifest) => this.#drawer.bound(manifest),
        manifest: (manifest) => {
          this.#drawer.bound(manifest);
          this.#scene.still = stillShare(manifest);
          this.begin();
          this.emit("manifest", manifest);
          if (manifest.audio) void this.#sound.listen();
        },
        changed: () => this.emit("change", null),
        ordered: () => this.emit("change", null),
        failed: (message, cause) => {
          this.#fail(new Error(cause));
          this.emit("error", { message, cause });
        },
      },
    );
    this.#scene.splatBudget = checkedSplats(options.splatBudget ?? Number.POSITIVE_INFINITY);
    this.#scene.subjectOnly = options.subjectOnly ?? null;
    this.#sound = new HostSound(options, this.#scene, this.#listeners.signal, {
      changed: () => this.emit("volumechange", null),
      failed: (problem) => this.emit("error", problem),
    });
    const { signal } = this.#listeners;
    document.addEventListener("visibilitychange", () => this.#visibility(), { signal });
    addEventListener("online", () => this.#scene.wake(), { signal });
    this.settled().then(
      () => this.emit("ready", null),
      () => {}, // reported by `error`, or intentional
    );
  }

  /** The scene's manifest; null until it has arrived. */
  get manifest(): Manifest | null {
    return this.#scene.manifest;
  }

  /**
   * Whether a scene with sound is muted. One that begins before the visitor has touched the page mutes itself, because
   * no browser allows sound then.
   */
  get muted(): boolean {
    return this.#sound.muted;
  }

  set muted(muted: boolean) {
    this.#sound.muted = muted;
  }

  /** Loudness, from 0 to 1; other numbers are clamped. */
  get volume(): number {
    return this.#sound.volume;
  }

  set volume(volume: number) {
    this.#sound.volume = volume;
  }

  /** Whether only moving splats are drawn; set null for the scene's own choice. */
  get subjectOnly(): boolean {
    return this.#scene.subjectOnly;
  }

  set subjectOnly(asked: boolean | null) {
    this.#scene.subjectOnly = asked;
    this.changed();
  }

  /**
   * Move a camera to a capture camera, with a field of view that contains its whole picture.
   *
   * @param name of the capture camera; the first if undefined.
   * @throws Error if the manifest has not arrived, or has no camera of that name.
   */
  lookFrom(camera: PerspectiveCamera, name: string | null = null): void {
    if (!this.manifest) throw new Error("the scene is not known yet: wait for the event manifest");
    this.updateWorldMatrix(true, false);
    lookFrom(camera, this.matrixWorld, this.manifest, name);
  }

  /** Stop for good and release everything but the host's context. */
  override dispose(): void {
    super.dispose();
    this.removeFromParent();
    this.#listeners.abort();
    this.#scene.dispose();
    this.#drawer.dispose();
    this.#fail(new DOMException("the scene has been disposed of", "AbortError"));
  }

  override copy(): never {
    throw new Error("an HgsScene cannot be copied or cloned: make another one of the same src");
  }

  protected get playback(): Playback | null {
    return this.#scene.playback;
  }

  protected changed(): void {
    this.emit("change", null);
  }

  protected async settled(): Promise<boolean> {
    const settled = new Promise<void>((resolve) => this.#waiting.push(resolve));
    this.changed();
    await Promise.race([settled, this.#failed]);
    return true;
  }

  #draw(renderer: Renderer, camera: Camera): void {
    if (this.#listeners.signal.aborted) return;
    try {
      this.#pictures.draw(this.#scene, renderer, camera, this.matrixWorld);
      this.#refused = null;
    } catch (error) {
      const cause = error instanceof Error ? error.message : String(error);
      if (cause === this.#refused) return; // reported once, not at every frame
      this.#refused = cause;
      // biome-ignore lint/suspicious/noConsole: the place where developers look for it
      console.warn(`HgsScene: ${cause}`);
      this.emit("error", { message: cause, cause });
    }
  }

  #framed(settled: boolean): void {
    if (this.#listeners.signal.aborted) return;
    if (settled) for (const resolve of this.#waiting.splice(0)) resolve();
    const clock = this.playback?.clock;
    if (!clock) return;
    this.#sound.framed();
    for (const type of this.#progress.since(clock, this.#scene.pictured, performance.now())) {
      if (type === "pause") this.asked.playing = false;
      this.emit(type, null);
    }
    if (clock.playing) this.emit("change", null);
  }

  /** The connection may have died while the page was hidden. */
  #visibility(): void {
    if (!document.hidden) this.#scene.wake();
    this.playback?.pageHidden(document.hidden);
  }

  protected emit<K extends keyof HgsSceneEvents>(type: K, detail: HgsSceneEvents[K]): void {
    (this.dispatchEvent as (event: { type: K; detail: HgsSceneEvents[K] }) => void).call(this, { type, detail });
  }
}
