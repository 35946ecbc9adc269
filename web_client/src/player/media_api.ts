/** The common interface of players and hosts' scenes: playing, under the names of HTMLMediaElement. */

import type { Manifest } from "../codec/types";
import { checkedRate } from "../scene/clock";
import type { Playback } from "../scene/playback";
import type { Beginning, PlayingOptions } from "./hgs_player_events";

/** Requested state of a scene: for the present one, and for one that is still to load. */
export interface Asked {
  playing: boolean;
  rate: number;
  loop: boolean;
  /** Seconds; null for the scene's start. */
  time: number | null;
}

/**
 * The requested state of the options.
 *
 * @throws RangeError if `playbackRate` is not in (0, 16].
 */
export function asked(options: PlayingOptions & Pick<Beginning, "time">): Asked {
  const { autoplay = false, playbackRate = 1, loop = false, time = null } = options;
  return { playing: autoplay, rate: checkedRate(playbackRate), loop, time };
}

/** Playing, paused or not. Times are seconds on the scene's clock, which runs from `start` to `end`. */
export abstract class MediaApi {
  /** The scene's manifest; null until it has arrived. */
  abstract readonly manifest: Manifest | null;
  protected abstract readonly asked: Asked;
  /** The playback; null until the manifest has arrived. */
  protected abstract readonly playback: Playback | null;

  /** The next picture may differ. */
  protected abstract changed(): void;
  /** Fulfilled when everything visible at the playhead is drawn, by false if there is no scene. */
  protected abstract settled(): Promise<boolean>;
  protected abstract emit(type: "ratechange" | "seeked", detail: null): void;

  /** Apply the earlier requests: the manifest has arrived. */
  protected begin(): void {
    const { loop, rate, time, playing } = this.asked;
    this.loop = loop;
    this.playback?.setRate(rate);
    if (time !== null) this.playback?.seek(time);
    if (playing) this.play();
    else this.pause();
  }

  /** Play; from the start if the end has been reached. Reported by `play`. */
  play(): void {
    this.asked.playing = true;
    this.playback?.play();
    this.changed();
  }

  pause(): void {
    this.asked.playing = false;
    this.playback?.pause();
    this.changed();
  }

  /**
   * Move the playhead, within the scene.
   *
   * @returns a promise that is fulfilled once everything visible then is drawn.
   * @throws RangeError if `time` is not a finite number.
   */
  async seek(time: number): Promise<void> {
    this.asked.time = checkedTime(time);
    this.playback?.seek(time);
    this.changed();
    if (await this.settled()) this.emit("seeked", null);
  }

  get paused(): boolean {
    return !(this.playback?.clock.playing ?? this.asked.playing);
  }

  /** True while the playhead waits for data. */
  get stalled(): boolean {
    return this.playback?.clock.stalled ?? false;
  }

  get ended(): boolean {
    const clock = this.playback?.clock;
    return clock ? !clock.playing && clock.time >= clock.end : false;
  }

  get currentTime(): number {
    return this.playback?.clock.time ?? this.asked.time ?? 0;
  }

  set currentTime(time: number) {
    this.seek(checkedTime(time)).catch(() => {}); // `error` reports failures
  }

  /** Start of the scene, seconds; 0 until the manifest has arrived. */
  get start(): number {
    return this.manifest?.start ?? 0;
  }

  /** End of the scene, seconds; NaN until the manifest has arrived. */
  get end(): number {
    return this.manifest?.end ?? Number.NaN;
  }

  /** Seconds from start to end; NaN until the manifest has arrived. */
  get duration(): number {
    return this.end - this.start;
  }

  /** The loaded stretches of time, as disjoint [start, end] in order. */
  get buffered(): readonly (readonly [number, number])[] {
    return this.playback?.buffer.ranges() ?? [];
  }

  /** Scene seconds per second, in (0, 16]; another number throws a RangeError. */
  get playbackRate(): number {
    return this.asked.rate;
  }

  set playbackRate(rate: number) {
    this.asked.rate = checkedRate(rate);
    this.playback?.setRate(rate);
    this.emit("ratechange", null);
  }

  /** Whether to begin again at the end. */
  get loop(): boolean {
    return this.asked.loop;
  }

  set loop(loop: boolean) {
    this.asked.loop = loop;
    if (this.playback) this.playback.clock.loop = loop;
  }
}

/** A class that extends `Base`, an event target or an object of a host, by the members that `Api` itself declares. */
export function withMembers<B extends abstract new (...args: never[]) => object, A extends MediaApi>(
  Base: B,
  // biome-ignore lint/suspicious/noExplicitAny: TypeScript requires it of a class with another one's members
  Api: abstract new (...args: any[]) => A,
  // biome-ignore lint/suspicious/noExplicitAny: likewise
): B & (abstract new (...args: any[]) => A) {
  abstract class Played extends (Base as unknown as new (...args: unknown[]) => object) {}
  const { constructor: _, ...members } = Object.getOwnPropertyDescriptors(Api.prototype);
  Object.defineProperties(Played.prototype, members);
  return Played as unknown as ReturnType<typeof withMembers<B, A>>;
}

function checkedTime(time: number): number {
  if (!Number.isFinite(time)) throw new RangeError(`time ${time} is not a finite number`);
  return time;
}
