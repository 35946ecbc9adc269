/** `@hgs/player/three`: a scene that streams and plays inside a host's scene of three.js. See docs/three.md. */

import { type Camera, Object3D, type PerspectiveCamera, type WebGLRenderer } from "three";
import type { Manifest } from "../codec/types";
import { checkedRate } from "../player/clock";
import type { Playback } from "../player/playback";
import { ProgressEvents } from "../player/progress_events";
import { StreamedScene } from "../player/streamed_scene";
import { openSource } from "../source/open_source";
import { lookFrom } from "./capture_view";
import type { HgsSceneEventMap, HgsSceneEvents, HgsSceneOptions } from "./hgs_scene_events";
import { HostPictures } from "./host_pictures";
import { SplatMesh } from "./splat_mesh";

export type { HgsSceneEventMap, HgsSceneEvents, HgsSceneOptions };

/**
 * One scene of moving splats. It has the scene's own space, which position, quaternion and one scale for all axes place in the
 * host's world. Times are seconds on the scene's clock, which runs from `start` to `end`; it moves on when the host draws.
 *
 * @example
 * const scene = new HgsScene({ src: "studio/manifest.json", loop: true, autoplay: true });
 * threeScene.add(scene);
 */
export class HgsScene extends Object3D<HgsSceneEventMap> {
  override readonly type: string = "HgsScene";
  readonly #mesh: SplatMesh;
  readonly #pictures: HostPictures;
  readonly #scene: StreamedScene;
  readonly #progress = new ProgressEvents();
  readonly #listeners = new AbortController();
  readonly #waiting: (() => void)[] = [];
  readonly #failed: Promise<never>;
  #fail: (error: Error) => void = () => {};
  #refused: string | null = null;
  // What is asked for counts for the scene that is there, and for one that is still to come.
  #playing: boolean;
  #rate: number;
  #loop: boolean;
  #time: number | null;

  /**
   * @throws Error with one line for people if no scene can be at such an address.
   * @throws RangeError if `playbackRate` is not in (0, 16].
   */
  constructor(options: HgsSceneOptions) {
    super();
    const { src, time = null, autoplay = false, loop = false, playbackRate = 1, antialiased = null } = options;
    this.#playing = autoplay;
    this.#rate = checkedRate(playbackRate);
    this.#loop = loop;
    this.#time = time;
    this.#failed = new Promise((_, reject) => {
      this.#fail = reject;
    });
    this.#failed.catch(() => {}); // for whoever waits; all others hear of it by the event
    this.#pictures = new HostPictures(options.linear ?? null, {
      frame: (settled) => this.#framed(settled),
      restored: () => {
        this.#scene.restore();
        this.#tell("change", null);
      },
    });
    this.#scene = new StreamedScene(
      {
        open: typeof src === "string" ? openSource(src) : src,
        sink: this.#pictures.sink,
        time,
        playing: autoplay,
        antialiased,
        memoryBudget: options.memoryBudget,
      },
      {
        manifest: (manifest) => this.#begin(manifest),
        changed: () => this.#tell("change", null),
        ordered: () => this.#tell("change", null),
        failed: (message, cause) => {
          this.#fail(new Error(cause));
          this.#tell("error", { message, cause });
        },
      },
    );
    this.#mesh = new SplatMesh((renderer, camera) => this.#draw(renderer, camera));
    this.add(this.#mesh);
    const { signal } = this.#listeners;
    document.addEventListener("visibilitychange", () => this.#visibility(), { signal });
    addEventListener("online", () => this.#scene.wake(), { signal });
    this.#settle("ready").catch(() => {}); // told by `error`, or left on purpose
  }

  /** Begin to play or go on; from the start if the end has been reached. Told by `play`. */
  play(): void {
    this.#playing = true;
    this.#playback?.play();
    this.#tell("change", null);
  }

  pause(): void {
    this.#playing = false;
    this.#playback?.pause();
    this.#tell("change", null);
  }

  /**
   * Move the playhead, within the scene.
   *
   * @returns a promise that is fulfilled once the host has drawn all of what is to be seen then.
   * @throws RangeError if `time` is not a finite number.
   */
  async seek(time: number): Promise<void> {
    if (!Number.isFinite(time)) throw new RangeError(`time ${time} is not a finite number`);
    this.#time = time;
    this.#playback?.seek(time);
    await this.#settle("seeked");
  }

  get paused(): boolean {
    return !(this.#playback?.clock.playing ?? this.#playing);
  }

  /** True while the playhead waits for data. */
  get stalled(): boolean {
    return this.#playback?.clock.stalled ?? false;
  }

  get ended(): boolean {
    const clock = this.#playback?.clock;
    return clock ? !clock.playing && clock.time >= clock.end : false;
  }

  get currentTime(): number {
    return this.#playback?.clock.time ?? this.#time ?? 0;
  }

  set currentTime(time: number) {
    if (!Number.isFinite(time)) throw new RangeError(`time ${time} is not a finite number`);
    this.seek(time).catch(() => {}); // what fails is told by `error`
  }

  /** Of the scene, seconds; 0 until it is known. */
  get start(): number {
    return this.manifest?.start ?? 0;
  }

  /** Of the scene, seconds; NaN until it is known. */
  get end(): number {
    return this.manifest?.end ?? Number.NaN;
  }

  /** Seconds from start to end; NaN until it is known. */
  get duration(): number {
    return this.end - this.start;
  }

  /** The stretches of time that are loaded, as disjoint [start, end] in order. */
  get buffered(): readonly (readonly [number, number])[] {
    return this.#playback?.buffer.ranges() ?? [];
  }

  /** Scene seconds per second, in (0, 16]; another number throws a RangeError. */
  get playbackRate(): number {
    return this.#rate;
  }

  set playbackRate(rate: number) {
    this.#rate = checkedRate(rate);
    this.#playback?.setRate(rate);
    this.#tell("ratechange", null);
  }

  /** Whether to begin again at the end. */
  get loop(): boolean {
    return this.#loop;
  }

  set loop(loop: boolean) {
    this.#loop = loop;
    if (this.#playback) this.#playback.clock.loop = loop;
  }

  /** What the scene says of itself; null until it has come. */
  get manifest(): Manifest | null {
    return this.#scene.manifest;
  }

  /**
   * Put a camera where one of the capture stood, as wide as to see all of that one's picture.
   *
   * @param name of the capture camera; the first if left out.
   * @throws Error if the scene is not known yet, or has no camera of that name.
   */
  lookFrom(camera: PerspectiveCamera, name: string | null = null): void {
    if (!this.manifest) throw new Error("the scene is not known yet: wait for the event manifest");
    this.updateWorldMatrix(true, false);
    lookFrom(camera, this.matrixWorld, this.manifest, name);
  }

  /** Stop for good and give everything back but the host's context. */
  override dispose(): void {
    super.dispose();
    this.removeFromParent();
    this.#listeners.abort();
    this.#scene.dispose();
    this.#pictures.dispose();
    this.#mesh.dispose();
    this.#fail(new DOMException("the scene has been disposed of", "AbortError"));
  }

  override copy(): never {
    throw new Error("an HgsScene cannot be copied or cloned: make another one of the same src");
  }

  get #playback(): Playback | null {
    return this.#scene.playback;
  }

  /** The scene is known: what was asked for before counts now. */
  #begin(manifest: Manifest): void {
    this.#mesh.bound(manifest);
    const playback = this.#playback;
    if (playback) {
      playback.clock.loop = this.#loop;
      playback.setRate(this.#rate);
      if (this.#time !== null) playback.seek(this.#time);
      if (this.#playing) playback.play();
      else playback.pause();
    }
    this.#tell("manifest", manifest);
  }

  #draw(renderer: WebGLRenderer, camera: Camera): void {
    if (this.#listeners.signal.aborted) return;
    try {
      this.#pictures.draw(this.#scene, renderer, camera, this.matrixWorld);
      this.#refused = null;
    } catch (error) {
      const cause = error instanceof Error ? error.message : String(error);
      if (cause === this.#refused) return; // said once, not at every frame
      this.#refused = cause;
      // biome-ignore lint/suspicious/noConsole: whoever has put the scene there looks for it here
      console.warn(`HgsScene: ${cause}`);
      this.#tell("error", { message: cause, cause });
    }
  }

  #framed(settled: boolean): void {
    if (this.#listeners.signal.aborted) return;
    if (settled) for (const resolve of this.#waiting.splice(0)) resolve();
    const clock = this.#playback?.clock;
    if (!clock) return;
    for (const type of this.#progress.since(clock, this.#scene.orders.count > 0, performance.now())) {
      if (type === "pause") this.#playing = false;
      this.#tell(type, null);
    }
    if (clock.playing) this.#tell("change", null);
  }

  /** Fulfilled when all of what is to be seen at the playhead is drawn, which is told; rejected if that cannot be. */
  async #settle(told: "ready" | "seeked"): Promise<void> {
    const settled = new Promise<void>((resolve) => this.#waiting.push(resolve));
    this.#tell("change", null);
    await Promise.race([settled, this.#failed]);
    this.#tell(told, null);
  }

  /** While the page was hidden the connection may have died. */
  #visibility(): void {
    if (!document.hidden) this.#scene.wake();
    this.#playback?.pageHidden(document.hidden);
  }

  #tell<K extends keyof HgsSceneEvents>(type: K, detail: HgsSceneEvents[K]): void {
    (this.dispatchEvent as (event: { type: K; detail: HgsSceneEvents[K] }) => void).call(this, { type, detail });
  }
}
