/** A line over the picture that says what a key or a button has done, and goes by itself. */

import { element } from "../dom/element";

/** Long enough to read a line, milliseconds. */
const STAY = 2500;

export class Message {
  readonly node = element("p", { class: "message", role: "status" });
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(signal: AbortSignal) {
    signal.addEventListener("abort", () => clearTimeout(this.#timer));
  }

  say(text: string): void {
    clearTimeout(this.#timer);
    this.node.textContent = text;
    this.#timer = setTimeout(() => {
      this.node.textContent = "";
    }, STAY);
  }
}
