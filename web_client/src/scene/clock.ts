/** The playhead: play, pause, seek, rate, loop, and waiting for data. It owns no timer: callers pass the time. */

/** Longest step, seconds: a tab that was hidden continues where it stopped. */
const LONGEST_STEP = 0.25;

/**
 * Distance of a waiting playhead from the edge of a growing scene, seconds: at the edge itself the next segment is
 * shown.
 */
const EDGE = 0.001;

/**
 * A rate that a clock can run at, scene seconds per second.
 *
 * @throws RangeError outside (0, 16]
 */
export function checkedRate(rate: number): number {
  if (!(rate > 0 && rate <= 16)) throw new RangeError(`rate ${rate} is not in (0, 16]`);
  return rate;
}

export class PlayerClock {
  loop = true;
  /** The repeated stretch, seconds, independent of `loop`; null for none. */
  range: readonly [number, number] | null = null;
  /** Whether the scene grows: the playhead waits at its edge, and continues when `end` is later. */
  grows = false;
  #time: number;
  #rate = 1;
  #playing = false;
  #stalled = false;
  /** Time of the last tick, seconds of the caller's steady clock; null before. */
  ticked: number | null = null;

  /** Start a clock over [start, end] seconds of the scene, paused at the start. */
  constructor(
    readonly start: number,
    public end: number,
  ) {
    this.#time = start;
  }

  /** Seconds on the scene's clock. */
  get time(): number {
    return this.#time;
  }

  get playing(): boolean {
    return this.#playing;
  }

  /** Seconds: the end of the playhead's way. */
  get last(): number {
    return this.grows ? this.end - EDGE : this.end;
  }

  /** True while playing waits for data, or for the scene to grow. */
  get stalled(): boolean {
    return this.#stalled;
  }

  /** Scene seconds per second. */
  get rate(): number {
    return this.#rate;
  }

  set rate(value: number) {
    this.#rate = checkedRate(value);
  }

  /** Play; from the start if the end, or that of the range, has been reached. */
  play(): void {
    if (this.#playing) return;
    const [from, to] = this.range ?? [this.start, this.end];
    if (this.#time >= to) this.#time = from;
    this.#playing = true;
    this.ticked = null;
  }

  pause(): void {
    this.#playing = false;
    this.#stalled = false;
  }

  /** Move the playhead; clamped to the scene. */
  seek(time: number): void {
    this.#time = Math.min(this.last, Math.max(this.start, time));
    this.#stalled = false;
    this.ticked = null;
  }

  /**
   * Advance to `now` (seconds of any steady clock) and return the scene's time.
   *
   * The playhead enters no moment for which `ready` is false: it stalls, and resumes when the data is there.
   */
  tick(now: number, ready: (time: number) => boolean): number {
    const step = this.ticked === null ? 0 : Math.min(LONGEST_STEP, Math.max(0, now - this.ticked));
    this.ticked = now;
    if (!this.#playing) return this.#time;
    const next = this.after(step);
    this.#stalled = !ready(next);
    if (this.#stalled) return this.#time;
    this.#time = next;
    if (next === this.last) {
      this.#stalled = this.grows;
      this.#playing = this.grows;
    }
    return this.#time;
  }

  /** The playhead's time after a number of seconds of playing: `last` itself only if it stops there. */
  after(seconds: number): number {
    const next = this.#time + seconds * this.#rate;
    if (this.range && this.#time < this.range[1]) {
      const [from, to] = this.range;
      return next < to ? next : from + ((next - from) % (to - from));
    }
    if (next < this.last) return next;
    const duration = this.end - this.start;
    return this.grows || !this.loop || duration <= 0 ? this.last : this.start + ((next - this.start) % duration);
  }
}
