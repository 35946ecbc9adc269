/** How fast bytes go, from those of the last seconds. */

const WINDOW = 10; // seconds
const LEAST = 2; // seconds before anything is said

export class Speed {
  #samples: { readonly time: number; readonly bytes: number }[] = [];

  /** Note how many bytes there are in all at a time in seconds. */
  note(bytes: number, time: number): void {
    this.#samples.push({ time, bytes });
    while (this.#samples.length > 2 && this.#samples[1].time < time - WINDOW) this.#samples.shift();
  }

  /** Begin anew, after a pause. */
  reset(): void {
    this.#samples = [];
  }

  /** Bytes per second; null while nobody can tell. */
  perSecond(): number | null {
    const first = this.#samples[0];
    const last = this.#samples.at(-1);
    if (!first || !last || last.time - first.time < LEAST || last.bytes <= first.bytes) return null;
    return (last.bytes - first.bytes) / (last.time - first.time);
  }
}
