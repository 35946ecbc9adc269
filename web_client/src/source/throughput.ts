/** How fast downloads come that run side by side. */

const KEPT = 8; // downloads
const FIRST_GUESS = 250_000; // bytes per second, until one has come

export class Throughput {
  readonly #last: { readonly bytes: number; readonly begun: number; readonly ended: number }[] = [];

  /** A download has come; from when to when, milliseconds. */
  arrived(bytes: number, begun: number, ended: number): void {
    this.#last.push({ bytes, begun, ended });
    if (this.#last.length > KEPT) this.#last.shift();
  }

  /** Of the last downloads together. */
  get bytesPerSecond(): number {
    if (this.#last.length === 0) return FIRST_GUESS;
    const begun = Math.min(...this.#last.map((download) => download.begun));
    const ended = Math.max(...this.#last.map((download) => download.ended));
    const bytes = this.#last.reduce((sum, download) => sum + download.bytes, 0);
    return (1000 * bytes) / Math.max(1, ended - begun);
  }
}
