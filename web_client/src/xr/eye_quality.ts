/**
 * How finely a headset's pictures are drawn: as finely as the device keeps up with. A frame that is missed is felt by the
 * whole body, a coarser picture hardly.
 */

export interface EyeQuality {
  /** Of the full width and height. */
  readonly scale: number;
  /** Fixed foveation, 0 to 1. */
  readonly foveation: number;
  /** So many splats are drawn for each eye at most, the most useful ones. */
  readonly splats: number;
}

const ALL = Number.POSITIVE_INFINITY;

/** Finest first. */
export const EYE_QUALITIES: readonly EyeQuality[] = [
  { scale: 1, foveation: 0.25, splats: ALL },
  { scale: 0.85, foveation: 0.5, splats: ALL },
  { scale: 0.7, foveation: 0.75, splats: ALL },
  { scale: 0.55, foveation: 1, splats: ALL },
  { scale: 0.55, foveation: 1, splats: 200_000 },
  { scale: 0.55, foveation: 1, splats: 100_000 },
];

/** An interval this much longer than a frame means that a frame was missed. */
const LATE = 1.4;
/** So many frames are looked at before anything changes. */
const WINDOW = 72;
/** With more late ones than this share the picture becomes coarser. */
const TOO_MANY = 0.15;
/** Windows without trouble before a finer picture is tried; twice as many after every try that failed. */
const PATIENCE = 4;
const LONGEST_PATIENCE = 64;

export class EyeQualityControl {
  #step = 0;
  #last: number | null = null; // ms
  #frames = 0;
  #late = 0;
  #calm = 0; // windows
  #patience = PATIENCE;
  #tried = false; // the last change was to a finer picture

  /** @param frameRate that the device aims at, frames per second. */
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

  /** Frames have been held up for a reason of their own, such as a headset taken off: look anew. */
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

/** The rate to ask a headset for: the lowest that is comfortable, which leaves the most time for each picture. */
export function comfortableRate(supported: ArrayLike<number> | undefined): number | null {
  const rates = Array.from(supported ?? []).sort((a, b) => a - b);
  return rates.find((rate) => rate >= 72) ?? rates.at(-1) ?? null;
}
