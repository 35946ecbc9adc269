/** Bookmarks: marked moments of a scene. They live as long as the page; a shared link contains them. */

export interface Bookmarks {
  /** Seconds, ascending. */
  times: readonly number[];
}

/** Distance of marks below which they count as one, seconds. */
const APART = 0.01;

/** The marks with a mark at a moment, or without the one there. */
export function toggled(times: readonly number[], time: number): readonly number[] {
  const others = times.filter((mark) => Math.abs(mark - time) >= APART);
  return others.length === times.length ? [...others, time].sort((a, b) => a - b) : others;
}

/** The next mark after `time`, or the last one before it; null if there is none. */
export function neighbour(times: readonly number[], time: number, direction: 1 | -1): number | null {
  if (direction === 1) return times.find((mark) => mark > time + APART) ?? null;
  return times.filter((mark) => mark < time - APART).at(-1) ?? null;
}
