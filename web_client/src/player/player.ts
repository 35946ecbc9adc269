/** Plays one scene on a canvas: joins the stream, the worker, the buffer, the clock and the renderer. */

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
import { FrameRate } from "./frame_rate";
import { type OrderKey, OrderRequests } from "./order_requests";
import type { PlayerOptions, PlayerStats } from "./player_types";
import { Stillness } from "./stillness";
import { sameView, type View } from "./view";

export class ScenePlayer {
  readonly #options: PlayerOptions;
  readonly #renderer: SplatRenderer;
  readonly #worker: Worker;
  readonly #orders: OrderRequests;
  readonly #stream: SceneStream;
  readonly #chunks: ChunkIntake;
  readonly #abort = new AbortController();
  readonly #frames = new FrameRate();
  readonly #stillness = new Stillness();
  readonly #waiting: (() => void)[] = [];
  #scene: { manifest: Manifest; buffer: SceneBuffer; clock: PlayerClock } | null = null;
  #animation = 0;
  #version = 0; // of what the worker has decoded
  #drawn: View | null = null; // null when the picture is out of date
  #quick = false; // how it was drawn
  #stalled = false;
  #streamState: StreamState = "connecting";
  #bytes = 0;
  #firstFrame: number | null = null;

  /** @throws Error if the browser has no WebGL2. */
  constructor(options: PlayerOptions) {
    this.#options = options;
    this.#renderer = new SplatRenderer(options.canvas, () => {
      this.#orders.forget();
      this.#drawn = null;
    });
    this.#orders = new OrderRequests((message, transfer) => this.#tell(message, transfer), this.#renderer);
    this.#worker = new Worker(new URL("../worker/worker.ts", import.meta.url), { type: "module" });
    this.#worker.onmessage = ({ data }: MessageEvent<FromWorker>) => this.#fromWorker(data);
    this.#worker.onerror = (event) => options.onError(`the decoder stopped: ${event.message || "it did not load"}`);
    this.#chunks = new ChunkIntake(
      {
        decode: (id, bytes) => this.#tell({ type: "chunk", id, bytes }, [bytes.buffer]),
        consumed: (bytes) => this.#stream.consumed(bytes),
        lost: (id, message) => {
          // biome-ignore lint/suspicious/noConsole: the page says it in plain words; this is the cause
          console.warn(message);
          this.#scene?.buffer.lose(id);
        },
      },
      fetchChunk,
    );
    this.#stream = new SceneStream(
      options.streamUrl,
      {
        manifest: (bytes) => this.#begin(bytes),
        chunk: (id, bytes) => this.#chunks.arrived(id, bytes),
        missing: (id) => this.#scene?.buffer.lose(id),
        progress: (bytes) => {
          this.#bytes += bytes;
        },
        state: (state) => {
          this.#streamState = state;
        },
        failed: options.onError,
      },
      { time: options.time, rate: options.playing ? 1 : 0 },
    );
    const { signal } = this.#abort;
    document.addEventListener("visibilitychange", () => this.#visibility(), { signal });
    addEventListener("online", () => this.#stream.wake(), { signal });
    this.#animation = requestAnimationFrame((now) => this.#frame(now));
  }

  get clock(): PlayerClock | null {
    return this.#scene?.clock ?? null;
  }

  get buffer(): SceneBuffer | null {
    return this.#scene?.buffer ?? null;
  }

  get stats(): PlayerStats {
    const totals = this.#scene?.manifest.totals;
    return {
      stream: this.#streamState,
      bytes: this.#bytes,
      bytesTotal: totals ? totals.bytesStatic + totals.bytesDynamic : 0,
      splats: this.#renderer.count,
      dynamicSplats: this.#orders.dynamicSplats,
      lostChunks: this.#scene?.buffer.lost ?? 0,
      framesPerSecond: this.#frames.value,
      firstFrame: this.#firstFrame,
    };
  }

  play(): void {
    const clock = this.#scene?.clock;
    if (!clock) return;
    clock.play();
    this.#stream.play(clock.time, clock.rate);
  }

  pause(): void {
    const clock = this.#scene?.clock;
    if (!clock) return;
    clock.pause();
    this.#stalled = false;
    this.#stream.pause(clock.time);
  }

  setRate(rate: number): void {
    const clock = this.#scene?.clock;
    if (!clock) return;
    clock.rate = rate;
    if (clock.playing) this.#stream.play(clock.time, rate);
  }

  /** Move the playhead; what is missing there comes before everything else. */
  seek(time: number): void {
    const scene = this.#scene;
    if (!scene) return;
    scene.clock.seek(time);
    const at = scene.clock.time;
    if (!scene.buffer.ready(at)) this.#stream.seek(at);
    else if (scene.clock.playing) this.#stream.play(at, scene.clock.rate);
    else this.#stream.pause(at);
  }

  /** Resolves when everything that is alive at the playhead has arrived, has been sorted, and is drawn. */
  settled(): Promise<void> {
    return new Promise((resolve) => {
      this.#waiting.push(resolve);
    });
  }

  /** The picture as it is on the canvas, or in floats without the canvas's rounding; null before there is one. */
  readPixels(float = false): Pixels | null {
    const view = this.#options.view();
    if (!view || !this.#orders.shown) return null;
    const shot = this.#shot(view);
    return float ? this.#renderer.readFloatPixels(shot) : this.#renderer.readPixels(shot);
  }

  /** Stop and give everything back. */
  dispose(): void {
    cancelAnimationFrame(this.#animation);
    this.#abort.abort();
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
      this.#scene = { manifest, buffer: new SceneBuffer(manifest), clock };
      this.#renderer.background = manifest.background;
      this.#stream.playheadAt(clock.time);
      this.#options.onManifest(manifest);
      if (this.#options.playing) this.play();
    } catch (error) {
      this.#stream.close();
      this.#options.onError(error instanceof Error ? error.message : String(error));
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
        this.#scene?.buffer.arrived(message.id);
        this.#version++;
        this.#chunks.decoded(message.id);
        break;
      case "failed":
        void this.#chunks.damaged(message.id, message.message);
        break;
      case "ordered":
        this.#orders.receive(message);
        this.#drawn = null;
        break;
    }
  }

  #frame(now: number): void {
    this.#animation = requestAnimationFrame((next) => this.#frame(next));
    const view = this.#options.view();
    const scene = this.#scene;
    if (!scene || !view) return;
    const { clock, buffer } = scene;
    const time = clock.tick(now / 1000, (moment) => buffer.ready(moment));
    this.#stream.playheadAt(time);
    this.#reportStall(clock);
    const r = view.pose.rotation;
    const wanted: OrderKey = {
      axis: { x: r[6], y: r[7], z: r[8], offset: view.pose.translation[2], near: view.camera.near },
      time,
      version: this.#version,
    };
    this.#orders.want(wanted);
    const still = this.#stillness.update(view, clock.playing && !clock.stalled, now);
    this.#draw(view, this.#renderer.slow && !still, now);
    if (this.#settled(wanted, view, scene)) for (const resolve of this.#waiting.splice(0)) resolve();
  }

  /** Draw if the picture is out of date or was drawn quickly without need, once the device has done the last one. */
  #draw(view: View, quick: boolean, now: number): void {
    const current = sameView(this.#drawn, view) && (quick || !this.#quick);
    if (current || !this.#orders.shown || this.#renderer.busy(now)) return;
    this.#renderer.draw(this.#shot(view), quick);
    this.#drawn = view;
    this.#quick = quick;
    this.#frames.count(now);
    if (this.#firstFrame === null && this.#renderer.count > 0) this.#firstFrame = performance.now();
  }

  /** At the time of the order, so that what is drawn and what is alive always agree. */
  #shot(view: View): Shot {
    const antialiased = this.#options.antialiased ?? this.#scene?.manifest.antialiased ?? false;
    return { ...view, time: this.#orders.normalisedTime, antialiased };
  }

  /** Whether all that is alive is drawn; of a playing scene, at the time that is shown. */
  #settled(wanted: OrderKey, view: View, { buffer, clock }: { buffer: SceneBuffer; clock: PlayerClock }): boolean {
    const { shown } = this.#orders;
    if (!shown || this.#renderer.lost || !sameView(this.#drawn, view)) return false;
    if (!buffer.staticComplete || !buffer.ready(shown.time)) return false;
    return clock.playing ? shown.version === wanted.version : !this.#quick && this.#orders.shows(wanted);
  }

  /** The server's playhead runs ahead while this one waits; tell it. */
  #reportStall(clock: PlayerClock): void {
    if (clock.stalled === this.#stalled) return;
    this.#stalled = clock.stalled;
    if (clock.stalled) this.#stream.pause(clock.time);
    else if (clock.playing) this.#stream.play(clock.time, clock.rate);
  }

  /** A hidden page gets no frames: its playhead stands. The connection may have died meanwhile. */
  #visibility(): void {
    if (!document.hidden) this.#stream.wake();
    const clock = this.#scene?.clock;
    if (!clock?.playing) return;
    if (document.hidden) this.#stream.pause(clock.time);
    else this.#stream.play(clock.time, clock.rate);
  }
}
