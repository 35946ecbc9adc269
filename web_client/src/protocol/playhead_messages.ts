/** Messages about the playhead, limited in rate while it is dragged. */

import type { ClientMessage } from "./messages";

const GAP = 50; // ms between two messages

export type PlayheadMessage = Extract<ClientMessage, { type: "seek" | "play" | "pause" }>;

export class PlayheadMessages {
  /** The last message of each kind, in order of sending. */
  readonly #waiting = new Map<"seek" | "run", PlayheadMessage>();
  #sent = Number.NEGATIVE_INFINITY; // ms
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(readonly send: (message: PlayheadMessage) => void) {}

  /** Send now, or later unless a newer message of the kind replaces it. */
  put(message: PlayheadMessage): void {
    const kind = message.type === "seek" ? "seek" : "run";
    this.#waiting.delete(kind);
    this.#waiting.set(kind, message);
    const wait = this.#sent + GAP - performance.now();
    if (wait <= 0) this.#flush();
    else this.#timer ??= setTimeout(() => this.#flush(), wait);
  }

  /** Drop unsent messages. */
  clear(): void {
    clearTimeout(this.#timer);
    this.#timer = undefined;
    this.#waiting.clear();
  }

  #flush(): void {
    const messages = [...this.#waiting.values()];
    this.clear();
    this.#sent = performance.now();
    for (const message of messages) this.send(message);
  }
}
