/** The rows of a texture that are free; a chunk takes any of them, so that nothing is ever too scattered to be used. */

export class RowPool {
  readonly #free: number[];

  constructor(readonly rows: number) {
    this.#free = Array.from({ length: rows }, (_, i) => rows - 1 - i); // the lowest is taken first
  }

  get free(): number {
    return this.#free.length;
  }

  /** @throws RangeError if there are not so many. */
  take(count: number): number[] {
    if (count > this.#free.length)
      throw new RangeError(`${count} rows are asked for, and ${this.#free.length} are free`);
    return this.#free.splice(this.#free.length - count).reverse();
  }

  give(rows: readonly number[]): void {
    this.#free.push(...rows);
    this.#free.sort((a, b) => b - a);
  }
}
