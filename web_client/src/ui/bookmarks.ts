/** Marked moments of a scene, in order. They live as long as the page; a shared link carries them on. */

/** Marks nearer than this are one, seconds. */
const APART = 0.01;

export class Bookmarks {
  #times: readonly number[];
  readonly #onChange: () => void;

  /** @param times seconds, in any order. */
  constructor(times: readonly number[], onChange: () => void) {
    this.#times = [...times].sort((a, b) => a - b);
    this.#onChange = onChange;
  }

  /** Seconds, ascending. */
  get times(): readonly number[] {
    return this.#times;
  }

  /** Mark a moment, or take away the mark that is there; returns whether there is one now. */
  toggle(time: number): boolean {
    const others = this.#times.filter((mark) => Math.abs(mark - time) >= APART);
    const marked = others.length === this.#times.length;
    this.#times = marked ? [...others, time].sort((a, b) => a - b) : others;
    this.#onChange();
    return marked;
  }

  /** The next mark after `time`, or the last one before it; null if there is none. */
  neighbour(time: number, direction: 1 | -1): number | null {
    if (direction === 1) return this.#times.find((mark) => mark > time + APART) ?? null;
    return this.#times.filter((mark) => mark < time - APART).at(-1) ?? null;
  }
}
