/** Marks of splats, with steps back and forth: selected, hidden, and deleted ones. */

export const SELECTED = 1;
export const HIDDEN = 2;
export const DELETED = 4;

/** Splats by the ids of their chunks: their places in them, ascending. */
export type Places = ReadonlyMap<string, readonly number[]>;

/** Ranges of places by the ids of chunks; both ends count. */
export type Ranges = Readonly<Record<string, readonly (readonly [number, number])[]>>;

interface Change {
  readonly id: string;
  readonly at: readonly number[];
  readonly before: Uint8Array;
  readonly after: Uint8Array;
}

export class SplatMarks {
  readonly #marks = new Map<string, Uint8Array>();
  readonly #past: Change[][] = [];
  readonly #future: Change[][] = [];

  /**
   * Begin without marks.
   *
   * @param sizeOf returns a chunk's number of splats.
   * @param changed is called with the ids of chunks after every change.
   */
  constructor(
    readonly sizeOf: (id: string) => number,
    readonly changed: (ids: readonly string[]) => void,
  ) {}

  /** The marks of a chunk's splats; undefined if none was ever marked. */
  of(id: string): Uint8Array | undefined {
    return this.#marks.get(id);
  }

  /** The ids of the chunks with marks, also removed ones. */
  get ids(): string[] {
    return [...this.#marks.keys()];
  }

  get canUndo(): boolean {
    return this.#past.length > 0;
  }

  get canRedo(): boolean {
    return this.#future.length > 0;
  }

  /** Number of splats with any of the marks `mask`, and with none of `without`. */
  count(mask: number, without = 0): number {
    let sum = 0;
    for (const marks of this.#marks.values()) for (const mark of marks) if (mark & mask && !(mark & without)) sum++;
    return sum;
  }

  /** The places of the splats with any of the marks `mask`. */
  places(mask: number): Map<string, number[]> {
    const found = new Map<string, number[]>();
    for (const [id, marks] of this.#marks) {
      const at: number[] = [];
      for (let i = 0; i < marks.length; i++) if (marks[i] & mask) at.push(i);
      if (at.length > 0) found.set(id, at);
    }
    return found;
  }

  /** Change the marks of splats in one step; a step without effect is none. */
  change(places: Places, to: (mark: number) => number): void {
    const step: Change[] = [];
    for (const [id, all] of places) {
      const marks = this.#marks.get(id) ?? new Uint8Array(this.sizeOf(id));
      const at = all.filter((i) => to(marks[i]) !== marks[i]);
      if (at.length === 0) continue;
      this.#marks.set(id, marks);
      const before = Uint8Array.from(at, (i) => marks[i]);
      step.push({ id, at, before, after: before.map(to) });
    }
    if (step.length === 0) return;
    this.#past.push(step);
    this.#future.length = 0;
    this.#write(step, "after");
  }

  undo(): void {
    const step = this.#past.pop();
    if (!step) return;
    this.#future.push(step);
    this.#write(step, "before");
  }

  redo(): void {
    const step = this.#future.pop();
    if (!step) return;
    this.#past.push(step);
    this.#write(step, "after");
  }

  /** The deleted splats. */
  deleted(): Ranges {
    const found: Record<string, [number, number][]> = {};
    for (const [id, places] of this.places(DELETED)) {
      const ranges: [number, number][] = [];
      for (const place of places) {
        const last = ranges.at(-1);
        if (last && last[1] === place - 1) last[1] = place;
        else ranges.push([place, place]);
      }
      found[id] = ranges;
    }
    return found;
  }

  #write(step: readonly Change[], side: "before" | "after"): void {
    for (const { id, at, [side]: values } of step) {
      const marks = this.#marks.get(id);
      if (marks) for (let i = 0; i < at.length; i++) marks[at[i]] = values[i];
    }
    this.changed(step.map(({ id }) => id));
  }
}

/** The file of `hgs edit --splats` (docs/editing.md). */
export const splatList = (chunks: Ranges): string => JSON.stringify({ format: "hgs-splats", version: 1, chunks });
