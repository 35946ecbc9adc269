/**
 * The fineness of pictures: their share of the canvas's resolution, and blending in half floats or 8 bits. Half floats
 * round hundreds of faint splats once instead of each (measured on a trained scene: 6 to 10 dB nearer to the exact
 * picture), and cost about a quarter more.
 */

/** A viewer's choice. Auto: as fine as the device can at a steady rate while something moves, and finest at rest. */
export type Quality = "auto" | "high" | "medium" | "low";

export const QUALITIES: readonly Quality[] = ["auto", "high", "medium", "low"];

export interface Fineness {
  /** Factor of the canvas's width and height. */
  readonly scale: number;
  readonly float: boolean;
  /** Largest number of splats; the most useful ones are drawn. */
  readonly splats: number;
  /** Cost relative to the finest: pixels, half floats and the number of splats count. */
  readonly cost: number;
}

/** A budget of splats for slow devices. */
const FEW = 100_000;

const fineness = (scale: number, float: boolean, splats = Number.POSITIVE_INFINITY): Fineness => ({
  scale,
  float,
  splats,
  cost: scale * scale * (float ? 1 : 0.75) * (splats === FEW ? 0.6 : 1), // cost in a scene of twice as many
});

/** The rungs, finest first. */
export const LADDER: readonly Fineness[] = [
  fineness(1, true),
  fineness(1, false),
  fineness(0.71, false),
  fineness(0.5, false),
  fineness(0.35, false),
  fineness(0.35, false, FEW),
];

const FIXED: Readonly<Record<Exclude<Quality, "auto">, number>> = { high: 0, medium: 1, low: 3 };

/** Largest duration of a picture of a moving scene, milliseconds. */
const BUDGET = 1000 / 30;
/** Number of pictures in a measurement: the first ones wait for shaders and uploads. */
const MEMORY = 4;
/** Largest share of the budget for a finer picture, as a margin: without it the choice would swing. */
const CAUTION = 0.7;

export class QualityControl {
  quality: Quality = "auto";
  readonly #finest: number[] = []; // durations of recent pictures, converted to the finest, ms
  #step = 0;

  /** The rung of the ladder for pictures while something moves. */
  get moving(): number {
    return this.quality === "auto" ? this.#step : FIXED[this.quality];
  }

  /** The rung for pictures at rest. */
  get resting(): number {
    return this.quality === "auto" ? 0 : FIXED[this.quality];
  }

  /** Largest number of splats for a rung, the most useful ones; `Infinity` for all. */
  splats(rung: number): number {
    return this.quality === "low" ? FEW : LADDER[rung].splats;
  }

  /** Note the duration of a picture of a rung, milliseconds. */
  measured(duration: number, rung: number): void {
    const recent = this.#finest;
    recent.push(duration / LADDER[rung].cost);
    if (recent.length > MEMORY) recent.shift();
    if (recent.length < MEMORY) return;
    const finest = [...recent].sort((a, b) => a - b)[MEMORY >> 1];
    const fits = LADDER.findIndex(({ cost }, step) => finest * cost <= (step < this.#step ? CAUTION : 1) * BUDGET);
    this.#step = fits < 0 ? LADDER.length - 1 : fits;
  }
}

/**
 * A page's budget of splats.
 *
 * @throws RangeError if it is not at least 1.
 */
export function checkedSplats(budget: number): number {
  if (!(budget >= 1)) throw new RangeError(`a budget of ${budget} splats is not at least 1; Infinity is for all`);
  return budget;
}
