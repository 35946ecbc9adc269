/** Plays one scene on a canvas of its own: a frame of the browser moves the clock, asks for an order and draws. */

import { CanvasRenderer } from "../renderer/canvas_renderer";
import type { Pixels, Shot } from "../renderer/shot";
import type { SceneBuffer } from "./buffer";
import type { PlayerClock } from "./clock";
import { orderKey } from "./order_requests";
import { Picture } from "./picture";
import type { PlayerOptions, PlayerStats } from "./player_types";
import { StreamedScene } from "./streamed_scene";
import type { View } from "./view";

export class ScenePlayer {
  readonly #options: PlayerOptions;
  readonly #renderer: CanvasRenderer;
  readonly #scene: StreamedScene;
  readonly #abort = new AbortController();
  readonly #picture: Picture;
  readonly #waiting: (() => void)[] = [];
  #animation = 0; // 0 while no frame is asked for

  /** @throws Error if the browser has no WebGL2. */
  constructor(options: PlayerOptions) {
    this.#options = options;
    this.#renderer = new CanvasRenderer(options.canvas, (lost) => this.#contextChanged(lost));
    const { source: open, time, playing } = options;
    this.#scene = new StreamedScene(
      { open, time, playing, sink: this.#renderer.splats },
      {
        manifest: (manifest) => {
          this.#renderer.background = manifest.background;
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
    this.#picture = new Picture(this.#renderer, this.#scene.orders);
    const { signal } = this.#abort;
    document.addEventListener("visibilitychange", () => this.#visibility(), { signal });
    addEventListener("online", () => this.#scene.wake(), { signal });
    this.invalidate();
  }

  get clock(): PlayerClock | null {
    return this.#scene.playback?.clock ?? null;
  }

  get buffer(): SceneBuffer | null {
    return this.#scene.playback?.buffer ?? null;
  }

  get stats(): PlayerStats {
    const { manifest, orders, state: stream, bytes, version: chunks } = this.#scene;
    const totals = manifest?.totals;
    const now = performance.now();
    const { frames, first, orderAge } = this.#picture;
    return {
      stream,
      bytes,
      bytesTotal: totals ? totals.bytesStatic + totals.bytesDynamic : 0,
      lineRate: this.#scene.lineRate(now),
      chunks,
      lostChunks: this.buffer?.lost ?? 0,
      complete: this.buffer?.complete ?? false,
      splats: orders.count,
      dynamicSplats: orders.dynamicSplats,
      framesPerSecond: frames.rate(now),
      framesDrawn: frames.drawn,
      framesDropped: frames.dropped,
      sortTime: orders.sortTime,
      orderAge,
      contextLost: this.#renderer.lost,
      firstFrame: first,
    };
  }

  /** Something that shows has changed, such as the view: the next frame looks at it. Without news there are no frames. */
  invalidate(): void {
    if (this.#animation !== 0 || this.#abort.signal.aborted) return;
    this.#animation = requestAnimationFrame((now) => this.#frame(now));
  }

  play(): void {
    this.#scene.playback?.play();
    this.invalidate();
  }

  pause(): void {
    this.#scene.playback?.pause();
    this.invalidate();
  }

  setRate(rate: number): void {
    this.#scene.playback?.setRate(rate);
  }

  /** Move the playhead; what is missing there comes before everything else. */
  seek(time: number): void {
    this.#scene.playback?.seek(time);
    this.invalidate();
  }

  /** Resolves when everything that is alive at the playhead has arrived, has been sorted, and is drawn. */
  settled(): Promise<void> {
    return new Promise((resolve) => {
      this.#waiting.push(resolve);
      this.invalidate();
    });
  }

  /** The picture as it is on the canvas, or in floats without the canvas's rounding; null before there is one. */
  readPixels(float = false): Pixels | null {
    const view = this.#options.view();
    if (!view || !this.#scene.orders.shown) return null;
    const shot = this.#shot(view);
    this.invalidate(); // the device's pace is taken from every picture
    return float ? this.#renderer.readFloatPixels(shot) : this.#renderer.readPixels(shot);
  }

  /** Stop and give everything back. */
  dispose(): void {
    this.#abort.abort();
    cancelAnimationFrame(this.#animation);
    this.#scene.dispose();
    this.#renderer.dispose();
  }

  /** While the page was hidden the connection may have died. */
  #visibility(): void {
    if (!document.hidden) this.#scene.wake();
    this.#scene.playback?.pageHidden(document.hidden);
  }

  #contextChanged(lost: boolean): void {
    if (!lost) this.#scene.orders.forget();
    this.#picture.outdate();
    this.invalidate();
  }

  #frame(now: number): void {
    this.#animation = 0;
    if (this.#advance(now)) this.invalidate();
    else this.#picture.frames.rest();
    this.#options.onFrame();
  }

  /** Bring everything up to `now`, milliseconds; returns whether there is more to do at the next frame. */
  #advance(now: number): boolean {
    const view = this.#options.view();
    const { playback, orders, version } = this.#scene;
    if (!playback || !view) return false;
    const wanted = orderKey(view, playback.tick(now / 1000), version);
    orders.want(wanted);
    const unfinished = this.#picture.update(view, () => this.#shot(view), playback.moving, now);
    if (this.#picture.shows(view, playback.clock.playing) && this.#scene.settled(wanted)) {
      for (const resolve of this.#waiting.splice(0)) resolve();
    }
    return playback.clock.playing || unfinished;
  }

  /** At the time of the order, so that what is drawn and what is alive always agree. */
  #shot(view: View): Shot {
    const antialiased = this.#options.antialiased ?? this.#scene.manifest?.antialiased ?? false;
    return { ...view, time: this.#scene.orders.normalisedTime, antialiased };
  }
}
