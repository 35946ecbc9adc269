/** A part of the player that is loaded when it is first used. */

import { NOT_LOADED } from "../scene/failure_words";

export class LatePart<T> {
  #part: T | null = null;
  #coming: Promise<T> | null = null;

  /**
   * @param load its module, and make it.
   * @param failed is told one line for people if that cannot be done, and the cause; the next use tries again.
   * @param signal aborts when there is no more use for it.
   */
  constructor(
    readonly load: () => Promise<T>,
    readonly failed: (message: string, cause: unknown) => void,
    readonly signal: AbortSignal,
  ) {}

  /** Null until it has been used and has come. */
  get here(): T | null {
    return this.#part;
  }

  /** Do something with it: at once if it is here, else when it has come. */
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
