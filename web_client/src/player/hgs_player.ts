/** The player's interface for pages: a scene's picture in an element of the page, and all its operations. */

import type { Quality } from "../renderer/fineness";
import { checkedSplats } from "../renderer/fineness";
import type { PlayerClock } from "../scene/clock";
import { openSource } from "../source/open_source";
import type { OpenSource } from "../source/scene_source";
import { claimContext, leaveContext, offerContext, Readiness, type Tenant } from "./context_places";
import type { Beginning, HgsPlayerEvents, HgsPlayerOptions } from "./hgs_player_events";
import { type Asked, asked } from "./media_api";
import { MountedScene } from "./mounted_scene";
import { PlayerCamera } from "./player_camera";
import { PlayerReadings } from "./player_readings";

/**
 * A player of one scene at a time, without controls. Times are seconds on the scene's clock, which runs from `start` to `end`.
 *
 * @example
 * const player = new HgsPlayer(document.querySelector("#scene"), { loop: true });
 * await player.load("https://cdn.example/studio/manifest.json");
 * player.play();
 */
export class HgsPlayer extends PlayerReadings {
  /** The camera of the scene. */
  readonly camera = new PlayerCamera(() => this.#scene?.viewpoint ?? null);
  protected readonly asked: Asked;
  readonly #stage: HTMLElement;
  readonly #options: HgsPlayerOptions;
  readonly #disposed = new AbortController();
  #src: string | OpenSource | null = null;
  #beginning: Beginning = {};
  #scene: MountedScene | null = null;
  #seen = true;
  #waiting: { resolve(): void; reject(error: Error): void } | null = null; // pending request for a graphics context
  readonly #tenant: Tenant;
  #quality: Quality;
  #splatBudget: number;
  #subjectOnly: boolean | null;
  #muted: boolean;
  #volume: number;

  /**
   * Create a player.
   *
   * @param stage an element of the page with a size and a position of its own (not `static`); the picture fills it.
   * @throws RangeError if `playbackRate` is not in (0, 16], or `splatBudget` not at least 1.
   */
  constructor(stage: HTMLElement, options: HgsPlayerOptions = {}) {
    super();
    this.#stage = stage;
    this.#options = options;
    this.asked = asked(options);
    this.#quality = options.quality ?? "auto";
    this.#splatBudget = checkedSplats(options.splatBudget ?? Number.POSITIVE_INFINITY);
    this.#subjectOnly = options.subjectOnly ?? null;
    this.#muted = options.muted ?? false;
    this.#volume = options.volume ?? 1;
    const readiness = () => this.#readiness;
    const seen = () => this.#seen;
    this.#tenant = {
      get seen() {
        return seen();
      },
      get readiness() {
        return readiness();
      },
      take: () => {
        this.#waiting?.resolve();
        const plays = this.#scene?.player.wake();
        if (plays) this.play();
      },
      give: () => this.#scene?.player.rest(),
    };
    this.addEventListener("frame", () => offerContext(this.#tenant));
  }

  /**
   * Whether the player is visible, which pages need not set: one that is paused out of sight returns its graphics
   * context.
   */
  get seen(): boolean {
    return this.#seen;
  }

  set seen(seen: boolean) {
    this.#seen = seen;
    if (!this.#scene && !this.#waiting) return;
    if (seen) claimContext(this.#tenant);
    else offerContext(this.#tenant);
  }

  override play(): void {
    if (this.#scene) claimContext(this.#tenant);
    super.play();
  }

  /**
   * Load a scene in place of the present one.
   *
   * @param src its address (see `openSource`), or a source.
   * @param beginning the first view, in place of the player's options.
   * @returns a promise that is fulfilled once everything visible at the first time is drawn, and rejected if the scene
   *   cannot be shown or is replaced. Listeners of `error` may ignore it.
   */
  load(src: string | OpenSource, beginning: Beginning = {}): Promise<void> {
    this.#src = src;
    this.#beginning = beginning;
    const shown = this.#load(src);
    shown.then(
      () => this.emit("ready", null),
      () => {}, // reported by `error`, or intentional
    );
    return shown;
  }

  /** Load the same scene again, with the same view and time. See `load`. */
  reload(): Promise<void> {
    if (this.#src === null) return Promise.reject(new Error("nothing has been loaded yet"));
    const { currentTime } = this;
    const { view } = this.camera;
    const turnBack = () => {
      if (view) this.camera.view = view;
    };
    this.addEventListener("manifest", turnBack, { once: true });
    const shown = this.load(this.#src, { ...this.#beginning, loopRange: this.loopRange });
    this.currentTime = currentTime;
    return shown;
  }

  /** Remove the scene. */
  unload(): void {
    this.#waiting?.reject(new DOMException("the scene has been removed", "AbortError"));
    this.#scene?.dispose();
    leaveContext(this.#tenant);
    if (!this.#scene) return;
    this.#scene = null;
    this.asked.time = null; // another scene begins at its own start
  }

  /** Stop for good and release everything. */
  dispose(): void {
    this.unload();
    this.#disposed.abort();
  }

  /** Signal that aborts when the player is disposed of. */
  get disposed(): AbortSignal {
    return this.#disposed.signal;
  }

  /** Fineness of pictures: see `Quality`. */
  get quality(): Quality {
    return this.#quality;
  }

  set quality(quality: Quality) {
    this.#quality = quality;
    if (this.#scene) this.#scene.player.quality = quality;
  }

  /**
   * Largest number of splats drawn, the most useful ones of the view; at least 1, or a RangeError is thrown. Quality
   * `low`, `auto` on a slow device, and headsets may draw fewer.
   */
  get splatBudget(): number {
    return this.#splatBudget;
  }

  set splatBudget(budget: number) {
    this.#splatBudget = checkedSplats(budget);
    if (this.#scene) this.#scene.player.splatBudget = budget;
  }

  /** Whether only moving splats are drawn; set null for the scene's own choice. */
  get subjectOnly(): boolean {
    return this.#scene?.player.subjectOnly ?? this.#subjectOnly ?? false;
  }

  set subjectOnly(asked: boolean | null) {
    this.#subjectOnly = asked;
    if (this.#scene) this.#scene.player.subjectOnly = asked;
  }

  /**
   * Whether a scene with sound is muted. A player that begins before the visitor has touched the page mutes itself,
   * because no browser allows sound then.
   */
  get muted(): boolean {
    return this.#muted;
  }

  set muted(muted: boolean) {
    this.#muted = muted;
    this.emit("volumechange", null);
  }

  /** Loudness, from 0 to 1; other numbers are clamped. */
  get volume(): number {
    return this.#volume;
  }

  set volume(volume: number) {
    this.#volume = Math.min(1, Math.max(0, volume));
    this.emit("volumechange", null);
  }

  /** The stretch of time that playing repeats, seconds, independent of `loop`; null for none, and without a scene. */
  get loopRange(): readonly [number, number] | null {
    return this.#scene?.clock?.range ?? null;
  }

  /**
   * Set the repeated stretch.
   *
   * @throws RangeError unless start <= from < to <= end of the present scene.
   */
  set loopRange(range: readonly [number, number] | null) {
    const clock = this.#scene?.clock;
    if (range !== null && !(clock && clock.start <= range[0] && range[0] < range[1] && range[1] <= clock.end)) {
      throw new RangeError(`${range} is no stretch of time between ${this.start} and ${this.end}`);
    }
    if (clock) clock.range = range;
  }

  protected get mounted(): MountedScene | null {
    return this.#scene;
  }

  protected changed(): void {
    this.#scene?.player.invalidate();
  }

  protected async settled(): Promise<boolean> {
    const scene = this.#scene;
    if (scene) claimContext(this.#tenant);
    await scene?.settled();
    return scene !== null;
  }

  protected emit<K extends keyof HgsPlayerEvents>(type: K, detail: HgsPlayerEvents[K]): void {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }

  async #load(src: string | OpenSource): Promise<void> {
    if (this.#disposed.signal.aborted) throw new Error("this player has been disposed of");
    this.unload();
    this.asked.time = this.#beginning.time ?? this.asked.time;
    this.emit("loadstart", null);
    while (!claimContext(this.#tenant)) await this.#place(); // all contexts are in use
    try {
      const open = typeof src === "string" ? openSource(src) : src;
      const { antialiased = null, memoryBudget } = this.#options;
      const [time, playing, viewpoint] = [this.asked.time, this.asked.playing, this.#viewpoint()];
      const options = { open, time, playing, antialiased, memoryBudget, viewpoint };
      this.#scene = new MountedScene(this.#stage, options, (type, detail) => this.#relay(type, detail));
      this.#scene.player.quality = this.#quality;
      this.#scene.player.splatBudget = this.#splatBudget;
      this.#scene.player.subjectOnly = this.#subjectOnly;
    } catch (error) {
      leaveContext(this.#tenant);
      const message = error instanceof Error ? error.message : String(error);
      this.emit("error", { message, cause: message });
      throw error;
    }
    await this.#scene.settled();
  }

  /** Wait for a graphics context. */
  #place(): Promise<void> {
    const placed = new Promise<void>((resolve, reject) => {
      this.#waiting = { resolve, reject };
    });
    return placed.finally(() => {
      this.#waiting = null;
    });
  }

  get #readiness(): Readiness {
    const busy = this.#scene?.player.busy ?? true;
    if (!this.#seen && this.paused) return busy ? Readiness.Loading : Readiness.OutOfSight;
    if (busy) return Readiness.Never;
    return this.paused ? Readiness.Standing : Readiness.Playing;
  }

  /** Play the scene's sound, too. */
  async #listen(scene: MountedScene): Promise<void> {
    try {
      const { SceneSound } = await import("../sound/scene_sound"); // not needed for most scenes
      if (!scene.gone.aborted) new SceneSound(this, scene.player, scene.gone);
      this.emit("volumechange", null);
    } catch (error) {
      this.emit("error", { message: "The scene plays without its sound.", cause: String(error) });
    }
  }

  #viewpoint() {
    const { camera = null, exact = false, size = null } = { ...this.#options, ...this.#beginning };
    return { camera, exact, size };
  }

  #relay<K extends keyof HgsPlayerEvents>(type: K, detail: HgsPlayerEvents[K]): void {
    const scene = this.#scene;
    if (type === "manifest" && scene?.clock) {
      const { view = null, loopRange = null } = { ...this.#options, ...this.#beginning };
      if (view) scene.viewpoint.place(view);
      if (loopRange) scene.clock.range = within(loopRange, scene.clock);
      this.begin();
      if (scene.manifest?.audio) void this.#listen(scene);
    }
    if (type === "pause") this.asked.playing = false;
    if (type === "viewchange" && this.#seen && scene) claimContext(this.#tenant);
    this.emit(type, detail);
  }
}

/** The part of a stretch of time inside a scene; null if there is none. */
function within([from, to]: readonly [number, number], { start, end }: PlayerClock): readonly [number, number] | null {
  const range = [Math.max(from, start), Math.min(to, end)] as const;
  return range[0] < range[1] ? range : null;
}
