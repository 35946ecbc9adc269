/** A part of the player that is loaded at its first use. */

import { NOT_LOADED } from "../scene/failure_words";

export class LatePart<T> {
  #part: T | null = null;
  #coming: Promise<T> | null = null;

  /**
   * Prepare a part.
   *
   * @param load loads its module, and creates it.
   * @param failed is called with one line for people and the cause if that fails; the next use tries again.
   * @param signal aborts when the part is not needed any more.
   */
  constructor(
    readonly load: () => Promise<T>,
    readonly failed: (message: string, cause: unknown) => void,
    readonly signal: AbortSignal,
  ) {}

  /** The part; null until it was used and has loaded. */
  get here(): T | null {
    return this.#part;
  }

  /** Use the part: at once if it is loaded, else later. */
  use(then: (part: T) => void): void {
    if (this.#part) then(this.#part);
    else void this.#await(then);
  }

  async #await(then: (part: T) => void): Promise<void> {
    this.#coming ??= this.load();
    try {
      this.#part = await this.#coming;
    } catch (cause) {
      this.#coming = null;
      if (!this.signal.aborted) this.failed(NOT_LOADED, cause);
      return;
    }
    if (!this.signal.aborted) then(this.#part);
  }
}
