/** Playback of a buffer: the playhead's motion and waits, their reports to the source, and the events of a playhead. */

import type { SceneSource } from "../source/scene_source";
import type { SceneBuffer } from "./buffer";
import type { PlayerClock } from "./clock";

/** Seconds of playing without a stall that must be certain at the start, and after a stall. */
const FIRST = 1.5;
const AGAIN = 3;

export class Playback {
  #stalled = false; // the source's state
  #reserve = FIRST;

  /**
   * Play a buffer.
   *
   * @param bytesPerSecond rate of the line.
   */
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

  /** Move the playhead; missing chunks there have priority. */
  seek(time: number): void {
    this.clock.seek(time);
    this.#reserve = FIRST;
    const at = this.clock.time;
    if (!this.buffer.ready(at)) this.source.seek(at);
    else if (this.clock.playing) this.source.play(at, this.clock.rate);
    else this.source.pause(at);
  }

  /**
   * Advance to `now` (seconds of any steady clock) and return the scene's time. Until the scene is `pictured` the
   * playhead waits: nobody should miss its beginning.
   */
  tick(now: number, pictured = true): number {
    const { clock, buffer } = this;
    const waiting = clock.stalled; // a stalled playhead waits for a reserve
    const time = clock.tick(
      now,
      (moment) =>
        pictured &&
        buffer.playable(moment) &&
        (!waiting || buffer.lasts(moment, clock.rate, this.bytesPerSecond(), this.#reserve)),
    );
    if (this.moving) this.#reserve = AGAIN;
    this.source.playheadAt(time);
    // The source's playhead runs on while this one waits.
    if (clock.stalled !== this.#stalled) {
      this.#stalled = clock.stalled;
      if (this.#stalled) this.source.pause(time);
      else if (clock.playing) this.source.play(time, clock.rate);
    }
    return time;
  }

  /** Pause a hidden page's playhead: the page gets no frames. */
  pageHidden(hidden: boolean): void {
    if (!this.clock.playing) return;
    if (hidden) this.source.pause(this.clock.time);
    else this.source.play(this.clock.time, this.clock.rate);
  }
}

const TIME_GAP = 250; // ms between two events of a running playhead

export type ProgressEvent = "firstpicture" | "play" | "pause" | "stalled" | "playing" | "timeupdate" | "ended";

export class ProgressEvents {
  #pictured = false;
  #playing = false;
  #stalled = false;
  #time: number | null = null;
  #emittedAt = Number.NEGATIVE_INFINITY; // ms of the last of them

  /** The events since the last call; `pictured`: there is a picture. `now` in milliseconds. */
  since(clock: PlayerClock, pictured: boolean, now: number): ProgressEvent[] {
    const events: ProgressEvent[] = [];
    if (pictured && !this.#pictured) events.push("firstpicture");
    if (clock.playing && !this.#playing) events.push("play");
    if (clock.stalled !== this.#stalled && clock.playing) events.push(clock.stalled ? "stalled" : "playing");
    const paused = this.#playing && !clock.playing;
    const due = !clock.playing || now - this.#emittedAt >= TIME_GAP;
    if (clock.time !== this.#time && due) {
      events.push("timeupdate");
      this.#time = clock.time;
      this.#emittedAt = now;
    }
    if (paused) events.push("pause");
    if (paused && clock.time >= clock.end) events.push("ended");
    this.#pictured = pictured;
    this.#playing = clock.playing;
    this.#stalled = clock.stalled;
    return events;
  }
}
