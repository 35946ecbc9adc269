/** Turns what a player is from frame to frame into events: it plays, stands, waits, moves on, has ended. */

import type { PlayerClock } from "./clock";

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
