/**
 * A scene while it arrives and plays: the only owner of its source, worker, buffer and order of splats. Decoded splats
 * go to a sink, such as the renderer of a page, of a headset or of a host.
 */

import { type Rig, rigOf } from "../camera/magnification";
import type { Manifest } from "../codec/types";
import type { Shot } from "../renderer/shot";
import type { SceneSource, SourceState } from "../source/scene_source";
import { Throughput } from "../source/throughput";
import { SceneWorker } from "../worker/scene_worker";
import { SceneBuffer } from "./buffer";
import { PlayerClock } from "./clock";
import { DECODER_STOPPED, describeFailure } from "./failure_words";
import { drawnTime, nextMoment, normalised } from "./moment";
import { type OrderKey, OrderRequests } from "./order_requests";
import { Playback } from "./playback";
import { SceneChunks } from "./scene_chunks";
import type { SceneEvents, SceneOptions, SceneStep } from "./scene_types";
import { type Sight, sameSight, sightOf, type View } from "./view";

export class StreamedScene {
  readonly orders: OrderRequests;
  /** Largest number of splats per view, the most useful ones; from the next step on. */
  splatBudget = Number.POSITIVE_INFINITY;
  /** Factor of static splats' opacity in a view, from 0 to 1. */
  still: (view: View) => number = () => 1;
  /** The same in all views, by `subjectOnly`. */
  shown = () => Number(!this.subjectOnly);
  readonly #options: SceneOptions;
  readonly #events: SceneEvents;
  readonly #worker: SceneWorker;
  readonly source: SceneSource;
  readonly #chunks: SceneChunks;
  readonly #line = new Throughput();
  #manifest: Manifest | null = null;
  #rig: Rig = [];
  #subjectOnly: boolean | null = null;
  #playback: Playback | null = null; // null until the manifest has arrived
  #state: SourceState = "connecting";
  #bytes = 0;
  #pictureTime = 0;
  #pictured = false;
  #suspended = false; // true while there is nothing to draw into
  #lastSight: Sight | null = null;

  constructor(options: SceneOptions, events: SceneEvents) {
    this.#options = options;
    this.#events = events;
    this.#worker = new SceneWorker({
      decoded: (splats) => this.#chunks.decoded(splats),
      damaged: (id, message) => this.#chunks.damaged(id, message),
      packed: (splats) => this.#chunks.packed(splats),
      repacked: () => this.#chunks.repacked(),
      ordered: (order) => {
        this.orders.receive(order);
        events.ordered();
      },
      stopped: (cause) => events.failed(DECODER_STOPPED, cause),
    });
    this.orders = new OrderRequests(this.#worker, options.sink);
    this.#chunks = new SceneChunks({
      worker: this.#worker,
      sink: options.sink,
      source: () => this.source,
      changed: () => {
        this.#reside();
        events.changed();
      },
    });
    this.source = options.open(
      {
        manifest: (manifest) => this.#begin(manifest),
        grown: (later) => this.#grow(later),
        chunk: (id, bytes) => this.#chunks.arrived(id, bytes),
        missing: (id) => this.#chunks.missing(id),
        progress: (bytes) => {
          this.#bytes += bytes;
          this.#line.count(bytes, performance.now());
          events.changed();
        },
        state: (state) => {
          this.#state = state;
          events.changed();
        },
        failed: async (failure, detail) => events.failed(await describeFailure(failure), detail),
      },
      { time: options.time, rate: options.playing ? 1 : 0 },
    );
  }

  /** The manifest; null until it has arrived. */
  get manifest(): Manifest | null {
    return this.#manifest;
  }

  /** The playback; null until the manifest has arrived. */
  get playback(): Playback | null {
    return this.#playback;
  }

  /** Whether static splats are left out: by request, or else by the manifest's choice. */
  get subjectOnly(): boolean {
    return this.#subjectOnly ?? this.#manifest?.capturedSpace?.subjectOnly ?? false;
  }

  set subjectOnly(asked: boolean | null) {
    this.#subjectOnly = asked;
  }

  /** Number of chunks decoded by the worker. */
  get version(): number {
    return this.#chunks.version;
  }

  get state(): SourceState {
    return this.#state;
  }

  /** Chunk bytes that have arrived. */
  get bytes(): number {
    return this.#bytes;
  }

  /** The scene's time, seconds, of the last shot. */
  get pictureTime(): number {
    return this.#pictureTime;
  }

  /** Whether a step of the current sink had anything to draw. */
  get pictured(): boolean {
    return this.#pictured;
  }

  /** Bytes per second at `now`, milliseconds. */
  lineRate(now: number): number {
    return this.#line.rate(now);
  }

  /**
   * One frame: move the clock to `now`, milliseconds of any steady clock, request the order for `sight`, by default
   * the first view's, and return the shots of the views. Called by every kind of loop: a page's, a headset's, a host's. Null until the manifest has
   * arrived.
   */
  step(now: number, views: readonly [View, ...View[]], sight = sightOf(views)): SceneStep | null {
    const playback = this.#playback;
    if (!playback) return null;
    this.orders.frame(now);
    playback.tick(now / 1000, this.#pictured);
    this.#reside();
    const exact = this.#lastSight === null || sameSight(this.#lastSight, sight);
    this.#lastSight = sight;
    const { splatBudget: budget } = this;
    const moment = nextMoment(playback, this.orders.shown, this.orders.lead / 1000);
    if (!moment || this.#suspended) return { shots: [], moving: false, settled: false };
    const wanted = { ...sight, exact, budget, ...moment, version: this.#chunks.version };
    this.orders.want(wanted);
    const shots = this.orders.shown ? views.map((view) => this.shot(view)) : [];
    const settled = this.#settled(wanted);
    this.#pictured ||= !this.#chunks.restoring && shots.length > 0 && (this.orders.count > 0 || settled);
    return { shots, moving: playback.moving, settled };
  }

  /** The current shot of a view: at the playhead, or as near to it as the order `shown` allows. */
  shot(view: View, shown: OrderKey | null = this.orders.shown): Shot {
    const antialiased = this.#options.antialiased ?? this.#manifest?.antialiased ?? false;
    const still = view.still ?? this.still(view) * this.shown();
    const shot = { ...view, time: 0, antialiased, rig: this.#rig, still };
    if (!shown || !this.#manifest || !this.#playback) return shot;
    this.#pictureTime = drawnTime(shown, this.#playback.clock.time);
    return { ...shot, time: normalised(this.#manifest, shown, this.#pictureTime) };
  }

  /** Stop ordering and the playhead until `restore`: the sink takes nothing. */
  suspend(): void {
    this.#suspended = true;
    this.#pictured = false;
  }

  /** Refill the sink, which has lost everything. */
  restore(): void {
    this.#suspended = this.#pictured = false;
    this.orders.forget();
    this.#chunks.restore();
  }

  /** The network or the page is back. */
  wake(): void {
    this.source.wake();
  }

  /** Stop, and release everything but the sink. */
  dispose(): void {
    this.source.close();
    this.#chunks.dispose();
    this.#worker.dispose();
  }

  /**
   * Whether the shown order contains all splats alive at its time, or at that of `wanted` if the scene rests, and static
   * splats are in the middle of no switch.
   */
  #settled(wanted: OrderKey): boolean {
    const { shown } = this.orders;
    const playback = this.#playback;
    if (
      this.#chunks.restoring ||
      this.shown() % 1 > 0 ||
      !shown?.exact ||
      !playback?.buffer.staticComplete ||
      !playback.buffer.ready(shown.time) ||
      !playback.buffer.playable(playback.clock.time)
    )
      return false;
    return playback.clock.playing
      ? shown.version === wanted.version && shown.budget === wanted.budget
      : this.orders.shows(wanted);
  }

  #begin(manifest: Manifest): void {
    try {
      const buffer = new SceneBuffer(manifest);
      this.#chunks.begin(manifest, buffer, this.#options.memoryBudget);
      this.#worker.begin(manifest);
      const clock = new PlayerClock(manifest.start, manifest.end);
      clock.grows = manifest.live !== null;
      clock.seek(this.#options.time ?? manifest.start);
      this.#manifest = manifest;
      this.#rig = rigOf(manifest);
      this.#playback = new Playback(clock, buffer, this.source, () => this.#line.rate(performance.now()));
      if (this.#options.playing) this.#playback.play();
      this.#events.manifest(manifest); // a listener may pause
      this.#events.changed();
    } catch (error) {
      this.source.close();
      const { message } = error as Error;
      this.#events.failed(message, message);
    }
  }

  /** Update the manifest for all its users. */
  #grow(later: Manifest): void {
    const clock = this.#playback?.clock;
    if (!clock || !this.#manifest) return;
    const manifest = Object.assign(this.#manifest, later);
    clock.end = manifest.end;
    clock.grows = manifest.live !== null;
    this.#chunks.grow();
    this.#worker.begin(manifest);
    this.#events.grown?.(manifest);
    this.#events.changed();
  }

  /** Keep the chunks for the playhead in memory. */
  #reside(): void {
    const clock = this.#playback?.clock;
    if (clock) this.#chunks.reside(clock.time, () => this.orders.moments);
  }
}
