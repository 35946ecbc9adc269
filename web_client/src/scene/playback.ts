/** Moves the playhead, and tells the source, whose own playhead runs along, where this one goes and when it waits. */

import type { SceneSource } from "../source/scene_source";
import type { SceneBuffer } from "./buffer";
import type { PlayerClock } from "./clock";

/** Where it will wait again, playing begins at a place for so many seconds, and goes on for so many once it has waited. */
const FIRST = 1.5;
const AGAIN = 3;

export class Playback {
  #stalled = false; // as the source knows
  #reserve = FIRST;

  /** @param bytesPerSecond what the line brings. */
  constructor(
    readonly clock: PlayerClock,
    readonly buffer: SceneBuffer,
    readonly source: SceneSource,
    readonly bytesPerSecond: () => number = () => 0,
  ) {
    source.playheadAt(clock.time);
  }

  /** True while the scene moves, and is not waiting for data. */
  get moving(): boolean {
    return this.clock.playing && !this.clock.stalled;
  }

  /** True while the playhead waits for the scene to grow. */
  get atEdge(): boolean {
    return this.clock.grows && this.clock.time === this.clock.last;
  }

  play(): void {
    this.clock.play();
    this.source.play(this.clock.time, this.clock.rate);
  }

  pause(): void {
    this.clock.pause();
    this.#stalled = false;
    this.source.pause(this.clock.time);
  }

  /** Scene seconds per second. */
  setRate(rate: number): void {
    this.clock.rate = rate;
    if (this.clock.playing) this.source.play(this.clock.time, rate);
  }

  /** Move the playhead; what is missing there comes before everything else. */
  seek(time: number): void {
    this.clock.seek(time);
    this.#reserve = FIRST;
    const at = this.clock.time;
    if (!this.buffer.ready(at)) this.source.seek(at);
    else if (this.clock.playing) this.source.play(at, this.clock.rate);
    else this.source.pause(at);
  }

  /**
   * Advance to `now` (seconds of any steady clock) and return the scene's time. Until the scene is `pictured` the playhead
   * waits: nobody should miss its beginning.
   */
  tick(now: number, pictured = true): number {
    const { clock, buffer } = this;
    const waiting = clock.stalled; // one that has begun to wait does so until it need not soon wait again
    const time = clock.tick(
      now,
      (moment) =>
        pictured &&
        buffer.playable(moment) &&
        (!waiting || buffer.lasts(moment, clock.rate, this.bytesPerSecond(), this.#reserve)),
    );
    if (this.moving) this.#reserve = AGAIN;
    this.source.playheadAt(time);
    // The source's playhead runs ahead while this one waits.
    if (clock.stalled !== this.#stalled) {
      this.#stalled = clock.stalled;
      if (this.#stalled) this.source.pause(time);
      else if (clock.playing) this.source.play(time, clock.rate);
    }
    return time;
  }

  /** A hidden page gets no frames: its playhead stands. */
  pageHidden(hidden: boolean): void {
    if (!this.clock.playing) return;
    if (hidden) this.source.pause(this.clock.time);
    else this.source.play(this.clock.time, this.clock.rate);
  }
}

const TIME_GAP = 250; // ms between what is told of a running playhead

export type ProgressEvent = "firstpicture" | "play" | "pause" | "stalled" | "playing" | "timeupdate" | "ended";

export class ProgressEvents {
  #pictured = false;
  #playing = false;
  #stalled = false;
  #time: number | null = null;
  #toldAt = Number.NEGATIVE_INFINITY; // ms

  /** What has happened since the last call; `pictured`: there is a picture. `now` in milliseconds. */
  since(clock: PlayerClock, pictured: boolean, now: number): ProgressEvent[] {
    const events: ProgressEvent[] = [];
    if (pictured && !this.#pictured) events.push("firstpicture");
    if (clock.playing && !this.#playing) events.push("play");
    if (clock.stalled !== this.#stalled && clock.playing) events.push(clock.stalled ? "stalled" : "playing");
    const paused = this.#playing && !clock.playing;
    const due = !clock.playing || now - this.#toldAt >= TIME_GAP;
    if (clock.time !== this.#time && due) {
      events.push("timeupdate");
      this.#time = clock.time;
      this.#toldAt = now;
    }
    if (paused) events.push("pause");
    if (paused && clock.time >= clock.end) events.push("ended");
    this.#pictured = pictured;
    this.#playing = clock.playing;
    this.#stalled = clock.stalled;
    return events;
  }
}
