/**
 * The quality of a headset's pictures: as fine as the device can keep up with. The whole body feels a missed frame; it
 * hardly notices a coarser picture.
 */

export interface EyeQuality {
  /** Factor of the full width and height. */
  readonly scale: number;
  /** Fixed foveation, 0 to 1. */
  readonly foveation: number;
  /** Largest number of splats for each eye; the most useful ones are drawn. */
  readonly splats: number;
}

const ALL = Number.POSITIVE_INFINITY;

/** The qualities, finest first. */
export const EYE_QUALITIES: readonly EyeQuality[] = [
  { scale: 1, foveation: 0.25, splats: ALL },
  { scale: 0.85, foveation: 0.5, splats: ALL },
  { scale: 0.7, foveation: 0.75, splats: ALL },
  { scale: 0.55, foveation: 1, splats: ALL },
  { scale: 0.55, foveation: 1, splats: 200_000 },
  { scale: 0.55, foveation: 1, splats: 100_000 },
];

/** Relative interval between frames beyond which a frame was missed. */
const LATE = 1.4;
/** Frames in a measurement. */
const WINDOW = 72;
/** Share of late frames beyond which the picture becomes coarser. */
const TOO_MANY = 0.15;
/** Windows without late frames before a finer picture is tried; doubled after every failed try. */
const PATIENCE = 4;
const LONGEST_PATIENCE = 64;

export class EyeQualityControl {
  #step = 0;
  #last: number | null = null; // ms
  #frames = 0;
  #late = 0;
  #calm = 0; // windows
  #patience = PATIENCE;
  #tried = false; // true after a change to a finer picture

  /**
   * Control the quality.
   *
   * @param frameRate target of the device, frames per second.
   */
  constructor(public frameRate: number) {}

  get quality(): EyeQuality {
    return EYE_QUALITIES[this.#step];
  }

  /** Note a frame at `now`, milliseconds; returns whether the quality has changed. */
  frame(now: number): boolean {
    const interval = this.#last === null ? 0 : now - this.#last;
    this.#last = now;
    this.#frames++;
    if (interval > (LATE * 1000) / this.frameRate) this.#late++;
    if (this.#frames < WINDOW) return false;
    const step = this.#judge(this.#late / this.#frames);
    this.#frames = 0;
    this.#late = 0;
    const changed = step !== this.#step;
    this.#step = step;
    return changed;
  }

  /** Restart the measurement after an interruption, such as a headset taken off. */
  interrupted(): void {
    this.#last = null;
    this.#frames = 0;
    this.#late = 0;
  }

  #judge(late: number): number {
    if (late > TOO_MANY) {
      if (this.#tried) this.#patience = Math.min(LONGEST_PATIENCE, 2 * this.#patience);
      this.#tried = false;
      this.#calm = 0;
      return Math.min(EYE_QUALITIES.length - 1, this.#step + 1);
    }
    this.#calm++;
    if (this.#calm < this.#patience || this.#step === 0) return this.#step;
    this.#tried = true;
    this.#calm = 0;
    return this.#step - 1;
  }
}

/** The rate to request from a headset: the lowest comfortable one, which leaves the most time for each picture. */
export function comfortableRate(supported: ArrayLike<number> | undefined): number | null {
  const rates = Array.from(supported ?? []).sort((a, b) => a - b);
  return rates.find((rate) => rate >= 72) ?? rates.at(-1) ?? null;
}
