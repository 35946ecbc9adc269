/** Hides the controls while the scene plays and nobody touches anything. */

const IDLE = 3000; // ms

export class IdleHiding {
  #timer: ReturnType<typeof setTimeout> | undefined;

  /** @param keys where the player's keys are heard. */
  constructor(
    readonly root: HTMLElement,
    keys: EventTarget,
    readonly playing: () => boolean,
    signal: AbortSignal,
  ) {
    for (const type of ["pointermove", "pointerdown", "focusin"]) {
      root.addEventListener(type, () => this.#wake(), { signal, passive: true });
    }
    keys.addEventListener("keydown", () => this.#wake(), { signal, passive: true });
    signal.addEventListener("abort", () => clearTimeout(this.#timer));
    this.#wake();
  }

  #wake(): void {
    this.root.classList.remove("idle");
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#sleep(), IDLE);
  }

  #sleep(): void {
    const used = this.root.querySelector(
      ".transport :focus-visible, .top-bar :focus-visible, .menu:not([hidden]), dialog[open]",
    );
    if (this.playing() && !used) this.root.classList.add("idle");
    else this.#timer = setTimeout(() => this.#sleep(), IDLE);
  }
}
