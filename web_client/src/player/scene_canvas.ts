/**
 * A scene on a canvas of its own: each frame of the browser moves the clock, requests an order and draws. The session
 * of a headset, which uses the canvas's context, drives it instead, frame by frame.
 */

import { CanvasRenderer } from "../renderer/canvas_renderer";
import type { Quality } from "../renderer/fineness";
import type { Pixels, Shot } from "../renderer/shot";
import type { Playback } from "../scene/playback";
import type { SceneStep } from "../scene/scene_types";
import { StreamedScene } from "../scene/streamed_scene";
import type { Sight, View } from "../scene/view";
import type { SceneSource } from "../source/scene_source";
import { Picture } from "./picture";
import type { PlayerOptions, PlayerStats } from "./player_types";

export class SceneCanvas {
  readonly #options: PlayerOptions;
  /** The renderer, for external drivers: its context, background and splats. */
  readonly renderer: CanvasRenderer;
  readonly #scene: StreamedScene;
  readonly #abort = new AbortController();
  readonly #picture: Picture;
  readonly #waiting: (() => void)[] = [];
  #splatBudget = Number.POSITIVE_INFINITY;
  #animation = 0; // 0 without a requested frame
  #kept: HTMLCanvasElement | null = null; // the picture, while there is no context
  #setAside = false;
  #lostAt: number | null = null; // number of bytes received when the browser went offline
  readonly #loadStart = performance.now();
  #driven = false;

  /**
   * Open a scene on a canvas.
   *
   * @throws Error if the browser has no WebGL2.
   */
  constructor(options: PlayerOptions) {
    this.#options = options;
    this.renderer = new CanvasRenderer(options.canvas, (lost) => this.#contextChanged(lost));
    const { source: open, time, playing, antialiased, memoryBudget } = options;
    this.#scene = new StreamedScene(
      { open, time, playing, antialiased, memoryBudget, sink: this.renderer.splats },
      {
        manifest: (manifest) => {
          this.renderer.background = manifest.background;
          this.#fade();
          options.onManifest(manifest);
        },
        changed: () => this.invalidate(),
        ordered: () => {
          this.#picture.outdate();
          this.invalidate();
        },
        failed: options.onError,
      },
    );
    this.#picture = new Picture(this.renderer, this.#scene);
    const { signal } = this.#abort;
    document.addEventListener("visibilitychange", () => this.#visibility(), { signal });
    addEventListener("online", () => this.#line(true), { signal });
    addEventListener("offline", () => this.#line(false), { signal });
    this.invalidate();
  }

  /** The playback; null until the manifest has arrived. */
  get playback(): Playback | null {
    return this.#scene.playback;
  }

  /** The source of the scene. */
  get source(): SceneSource {
    return this.#scene.source;
  }

  get stats(): PlayerStats {
    const { manifest, orders, state: stream, bytes, version: chunks } = this.#scene;
    const totals = manifest?.totals;
    const now = performance.now();
    const { frames, first } = this.#picture;
    return {
      stream: bytes === this.#lostAt ? "retrying" : stream,
      bytes,
      bytesTotal: totals ? totals.bytesStatic + totals.bytesDynamic : 0,
      lineRate: this.#scene.lineRate(now),
      chunks,
      lostChunks: this.playback?.buffer.states.lost ?? 0,
      complete: this.playback?.buffer.complete ?? false,
      atEdge: this.playback?.atEdge ?? false,
      splats: orders.count,
      dynamicSplats: orders.dynamicSplats,
      framesPerSecond: frames.rate(now),
      framesDrawn: frames.drawn,
      framesDropped: frames.dropped,
      sortTime: orders.sortTime,
      orderAge: orders.age,
      orderAgeFrames: orders.ageInFrames,
      pictureTime: this.#scene.pictureTime,
      fineness: this.#picture.fineness,
      contextLost: this.renderer.lost && !this.renderer.given,
      setAside: this.#setAside,
      firstFrame: first,
      loadStart: this.#loadStart,
    };
  }

  /** Report a visible change, such as of the view, to the next frame. Without changes there are no frames. */
  invalidate(): void {
    if (this.#animation !== 0 || this.#driven || this.#abort.signal.aborted) return;
    this.#animation = requestAnimationFrame((now) => this.#frame(now));
  }

  /**
   * Let another loop drive: it calls `step` and draws, until `drive(false)` returns the canvas. Meanwhile the player
   * draws nothing and requests no frames.
   */
  drive(driven: boolean): void {
    this.#driven = driven;
    cancelAnimationFrame(this.#animation);
    this.#animation = 0;
    this.#picture.outdate(); // the canvas shows an earlier picture, or nothing
    this.invalidate();
  }

  /**
   * One frame of an external driver, at `now`, milliseconds of the clock of animation frames: moves the playhead,
   * requests the order for `sight`, of at most so many splats, and returns the shots to draw. No frame is skipped for
   * the device's sake. Null until the manifest has arrived.
   */
  step(now: number, views: readonly [View, ...View[]], sight: Sight, splats: number): SceneStep | null {
    this.#scene.splatBudget = Math.min(this.#splatBudget, splats);
    const step = this.#scene.step(now, views, sight);
    if (step?.shots.length) this.#picture.countFrame(now);
    this.#finish(step?.settled ?? false);
    return step;
  }

  /** Whether the context is needed: for the first picture, for a pending request, or for an external driver. */
  get busy(): boolean {
    return !this.#scene.pictured || this.#waiting.length > 0 || this.#driven;
  }

  /** Return the context, keep the picture, and pause, until `wake`. */
  rest(): void {
    const view = this.#options.view();
    if (view && this.#scene.pictured && !this.renderer.lost) {
      this.#unkeep();
      this.#kept = this.renderer.copy(this.#scene.shot(view));
      this.#kept.style.cssText = `${this.#options.canvas.style.cssText}; object-fit: cover; pointer-events: none`;
      this.#options.canvas.after(this.#kept);
    }
    if (this.playback?.clock.playing) {
      this.playback.pause();
      this.#setAside = true;
    }
    this.renderer.giveBack();
    this.#scene.suspend();
    this.invalidate();
  }

  /** Draw again, at the same time and with the same view; returns whether the scene played before `rest`. */
  wake(): boolean {
    const played = this.#setAside;
    this.#setAside = false;
    this.renderer.take();
    this.invalidate();
    return played;
  }

  get quality(): Quality {
    return this.renderer.quality.quality;
  }

  /** Fineness of pictures; see `Quality`. */
  set quality(quality: Quality) {
    this.renderer.quality.quality = quality;
    this.#picture.outdate();
    this.invalidate();
  }

  /** Largest number of splats per view, the most useful ones; some qualities draw fewer. */
  get splatBudget(): number {
    return this.#splatBudget;
  }

  set splatBudget(budget: number) {
    this.#splatBudget = budget;
    this.invalidate();
  }

  /** Whether static splats are left out; set null for the manifest's choice. */
  get subjectOnly(): boolean {
    return this.#scene.subjectOnly;
  }

  set subjectOnly(asked: boolean | null) {
    this.#scene.subjectOnly = asked;
    this.#fade();
    this.invalidate();
  }

  /** Resolves when everything visible at the playhead has arrived, has been sorted, and is drawn. */
  settled(): Promise<void> {
    return new Promise((resolve) => {
      this.#waiting.push(resolve);
      this.invalidate();
    });
  }

  /** The picture, as on the canvas or in the fineness of a rung of `LADDER`; null before the first. */
  readPixels(rung?: number): Pixels | null {
    if (this.#kept) return pixelsOf(this.#kept);
    this.invalidate(); // every picture measures the device's pace
    const { shot } = this;
    return shot && this.renderer.readPixels(shot, rung);
  }

  /** The shot of the current view; null before the first order, and without a context. */
  get shot(): Shot | null {
    const view = this.#options.view();
    return view && this.#scene.orders.shown && !this.renderer.lost ? this.#scene.shot(view) : null;
  }

  /** Stop and release everything. */
  dispose(): void {
    this.#abort.abort();
    cancelAnimationFrame(this.#animation);
    this.#unkeep();
    this.#scene.dispose();
    this.renderer.dispose();
  }

  /** The browser is online again, or offline: it detects that long before a connection does. */
  #line(there: boolean): void {
    this.#lostAt = there ? null : this.#scene.bytes;
    if (there) this.#scene.wake();
    this.invalidate();
  }

  /** The connection may have died while the page was hidden. */
  #visibility(): void {
    if (!document.hidden) this.#scene.wake();
    this.#scene.playback?.pageHidden(document.hidden);
  }

  /** Load the fading of static splats, where some may fade. */
  #fade(): void {
    const { manifest, subjectOnly } = this.#scene;
    if (!manifest || !(subjectOnly || manifest.capturedSpace?.cones)) return;
    import("./fading")
      .then(({ fade }) => {
        fade(this.#scene, this.renderer, manifest);
        this.#picture.outdate();
        this.invalidate();
      })
      .catch(() => {}); // shown as everywhere
  }

  #unkeep(): void {
    this.#kept?.remove();
    this.#kept = null;
  }

  #contextChanged(lost: boolean): void {
    if (lost) this.#scene.suspend();
    else this.#scene.restore();
    this.#picture.outdate();
    this.invalidate();
  }

  #frame(now: number): void {
    this.#animation = 0;
    const view = this.#options.view();
    const budget = () => Math.min(this.#splatBudget, this.#picture.splats);
    this.#scene.splatBudget = budget();
    const step = view && this.#scene.step(now, [view]);
    const shot = step?.shots[0];
    const playing = this.playback?.clock.playing ?? false;
    const unfinished = shot ? this.#picture.update(shot, step.moving, now) : false;
    const outgrown = this.#scene.splatBudget !== budget(); // motion has begun or ended
    if (unfinished || outgrown || (step && playing)) this.invalidate();
    else this.#picture.frames.rest();
    this.#finish(shot && !outgrown && this.#picture.shows(shot, playing) ? step.settled : false);
  }

  /** End a frame; `settled`: everything visible at the playhead is drawn. */
  #finish(settled: boolean): void {
    if (this.#kept && this.#scene.pictured && !this.renderer.lost) this.#unkeep();
    if (settled) for (const resolve of this.#waiting.splice(0)) resolve();
    this.#options.onFrame();
  }
}

function pixelsOf(picture: HTMLCanvasElement): Pixels | null {
  const { width, height } = picture;
  const read = picture.getContext("2d")?.getImageData(0, 0, width, height);
  return read ? { width, height, data: new Uint8Array(read.data.buffer) } : null;
}
