/** Plays one scene on a canvas: joins the stream, the worker, the buffer, the clock and the renderer. */

import { ManifestError } from "../codec/errors";
import { parseManifest } from "../codec/manifest";
import type { Manifest } from "../codec/types";
import { fetchChunk } from "../protocol/api";
import { SceneStream, type StreamState } from "../protocol/stream";
import { type Pixels, type Shot, SplatRenderer } from "../renderer/renderer";
import type { FromWorker, ToWorker } from "../worker/messages";
import { placeChunks } from "../worker/placement";
import { SceneBuffer } from "./buffer";
import { ChunkIntake } from "./chunk_intake";
import { PlayerClock } from "./clock";
import { DECODER_STOPPED, describeFailure, SCENE_UNREADABLE } from "./failure_words";
import { LineRate } from "./line_rate";
import { type OrderKey, OrderRequests, orderKey } from "./order_requests";
import { Picture } from "./picture";
import { Playback } from "./playback";
import type { PlayerOptions, PlayerStats } from "./player_types";
import type { View } from "./view";

export class ScenePlayer {
  readonly #options: PlayerOptions;
  readonly #renderer: SplatRenderer;
  readonly #worker: Worker;
  readonly #orders: OrderRequests;
  readonly #stream: SceneStream;
  readonly #chunks: ChunkIntake;
  readonly #abort = new AbortController();
  readonly #picture: Picture;
  readonly #line = new LineRate();
  readonly #waiting: (() => void)[] = [];
  #manifest: Manifest | null = null;
  #playback: Playback | null = null; // from the manifest on
  #animation = 0; // 0 while no frame is asked for
  #version = 0; // of what the worker has decoded
  #streamState: StreamState = "connecting";
  #bytes = 0;

  /** @throws Error if the browser has no WebGL2. */
  constructor(options: PlayerOptions) {
    this.#options = options;
    this.#renderer = new SplatRenderer(options.canvas, (lost) => this.#contextChanged(lost));
    this.#orders = new OrderRequests((message, transfer) => this.#tell(message, transfer), this.#renderer);
    this.#picture = new Picture(this.#renderer, this.#orders);
    this.#worker = new Worker(new URL("../worker/worker.ts", import.meta.url), { type: "module" });
    this.#worker.onmessage = ({ data }: MessageEvent<FromWorker>) => this.#fromWorker(data);
    this.#worker.onerror = ({ message }) => options.onError(DECODER_STOPPED, message);
    this.#chunks = new ChunkIntake(
      {
        decode: (id, bytes) => this.#tell({ type: "chunk", id, bytes }, [bytes.buffer]),
        consumed: (bytes) => this.#stream.consumed(bytes),
        lost: (id, message) => {
          // biome-ignore lint/suspicious/noConsole: the page says it in plain words; this is the cause
          console.warn(message);
          this.#lose(id);
        },
      },
      fetchChunk,
    );
    this.#stream = new SceneStream(
      options.streamUrl,
      {
        manifest: (bytes) => this.#begin(bytes),
        chunk: (id, bytes) => this.#chunks.arrived(id, bytes),
        missing: (id) => this.#lose(id),
        progress: (bytes) => {
          this.#bytes += bytes;
          this.#line.count(bytes, performance.now());
          this.invalidate();
        },
        state: (state) => {
          this.#streamState = state;
          this.invalidate();
        },
        failed: (failure, detail) => options.onError(describeFailure(failure), detail),
      },
      { time: options.time, rate: options.playing ? 1 : 0 },
    );
    const { signal } = this.#abort;
    document.addEventListener("visibilitychange", () => this.#visibility(), { signal });
    addEventListener("online", () => this.#stream.wake(), { signal });
    this.invalidate();
  }

  get clock(): PlayerClock | null {
    return this.#playback?.clock ?? null;
  }

  get buffer(): SceneBuffer | null {
    return this.#playback?.buffer ?? null;
  }

  get stats(): PlayerStats {
    const totals = this.#manifest?.totals;
    const now = performance.now();
    const { frames, first, orderAge } = this.#picture;
    return {
      stream: this.#streamState,
      bytes: this.#bytes,
      bytesTotal: totals ? totals.bytesStatic + totals.bytesDynamic : 0,
      lineRate: this.#line.rate(now),
      chunks: this.#version,
      lostChunks: this.#playback?.buffer.lost ?? 0,
      complete: this.#playback?.buffer.complete ?? false,
      splats: this.#renderer.count,
      dynamicSplats: this.#orders.dynamicSplats,
      framesPerSecond: frames.rate(now),
      framesDrawn: frames.drawn,
      framesDropped: frames.dropped,
      sortTime: this.#orders.sortTime,
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
    this.#playback?.play();
    this.invalidate();
  }

  pause(): void {
    this.#playback?.pause();
    this.invalidate();
  }

  setRate(rate: number): void {
    this.#playback?.setRate(rate);
  }

  /** Move the playhead; what is missing there comes before everything else. */
  seek(time: number): void {
    this.#playback?.seek(time);
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
    if (!view || !this.#orders.shown) return null;
    const shot = this.#shot(view);
    this.invalidate(); // the device's pace is taken from every picture
    return float ? this.#renderer.readFloatPixels(shot) : this.#renderer.readPixels(shot);
  }

  /** Stop and give everything back. */
  dispose(): void {
    this.#abort.abort();
    cancelAnimationFrame(this.#animation);
    this.#stream.close();
    this.#chunks.dispose();
    this.#worker.terminate();
    this.#renderer.dispose();
  }

  #begin(bytes: Uint8Array): void {
    try {
      const manifest = parseManifest(JSON.parse(new TextDecoder().decode(bytes)));
      const { staticRows, dynamicRows } = placeChunks(manifest);
      this.#renderer.allocate(staticRows, dynamicRows);
      this.#tell({ type: "scene", manifest });
      const clock = new PlayerClock(manifest.start, manifest.end);
      clock.seek(this.#options.time ?? manifest.start);
      this.#manifest = manifest;
      this.#playback = new Playback(clock, new SceneBuffer(manifest), this.#stream);
      this.#renderer.background = manifest.background;
      this.#options.onManifest(manifest);
      if (this.#options.playing) this.play();
    } catch (error) {
      this.#stream.close();
      const cause = error instanceof Error ? error.message : String(error);
      const unreadable = error instanceof ManifestError || error instanceof SyntaxError;
      this.#options.onError(unreadable ? SCENE_UNREADABLE : cause, cause);
    }
  }

  #tell(message: ToWorker, transfer: Transferable[] = []): void {
    this.#worker.postMessage(message, transfer);
  }

  #fromWorker(message: FromWorker): void {
    switch (message.type) {
      case "decoded":
        if (message.kind === "static") this.#renderer.writeStatics(message.first, message.texels);
        else this.#renderer.writeDynamics(message.first, message.texels, message.fifth);
        this.#playback?.buffer.arrived(message.id);
        this.#version++;
        this.#chunks.decoded(message.id);
        if (this.#playback?.buffer.complete) this.#stream.close(); // nothing more can come
        break;
      case "failed":
        void this.#chunks.damaged(message.id, message.message);
        break;
      case "ordered":
        this.#orders.receive(message);
        this.#picture.outdate();
        break;
    }
    this.invalidate();
  }

  /** While the page was hidden the connection may have died. */
  #visibility(): void {
    if (!document.hidden) this.#stream.wake();
    this.#playback?.pageHidden(document.hidden);
  }

  /** Go on without a chunk. */
  #lose(id: string): void {
    this.#playback?.buffer.lose(id);
    this.invalidate();
  }

  #contextChanged(lost: boolean): void {
    if (!lost) this.#orders.forget();
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
    const playback = this.#playback;
    if (!playback || !view) return false;
    const wanted = orderKey(view, playback.tick(now / 1000), this.#version);
    this.#orders.want(wanted);
    const unfinished = this.#picture.update(view, () => this.#shot(view), playback.moving, now);
    if (this.#settled(wanted, view, playback)) for (const resolve of this.#waiting.splice(0)) resolve();
    return playback.clock.playing || unfinished;
  }

  /** At the time of the order, so that what is drawn and what is alive always agree. */
  #shot(view: View): Shot {
    const antialiased = this.#options.antialiased ?? this.#manifest?.antialiased ?? false;
    return { ...view, time: this.#orders.normalisedTime, antialiased };
  }

  /** Whether all that is alive is drawn; of a playing scene, at the time that is shown. */
  #settled(wanted: OrderKey, view: View, { buffer, clock: { playing } }: Playback): boolean {
    const { shown } = this.#orders;
    if (!shown || !this.#picture.shows(view, playing)) return false;
    if (!buffer.staticComplete || !buffer.ready(shown.time)) return false;
    return playing ? shown.version === wanted.version : this.#orders.shows(wanted);
  }
}
