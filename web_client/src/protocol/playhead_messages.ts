/** Tells the server of the playhead, but not of every place that it passes while it is dragged. */

import type { ClientMessage } from "./messages";

const GAP = 50; // ms between what is told

export type PlayheadMessage = Extract<ClientMessage, { type: "seek" | "play" | "pause" }>;

export class PlayheadMessages {
  /** The last of each kind, in the order in which they are to be sent. */
  readonly #waiting = new Map<"seek" | "run", PlayheadMessage>();
  #sent = Number.NEGATIVE_INFINITY; // ms
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(readonly send: (message: PlayheadMessage) => void) {}

  /** Send at once, or when the time has come unless a later message of the kind takes its place. */
  put(message: PlayheadMessage): void {
    const kind = message.type === "seek" ? "seek" : "run";
    this.#waiting.delete(kind);
    this.#waiting.set(kind, message);
    const wait = this.#sent + GAP - performance.now();
    if (wait <= 0) this.#flush();
    else this.#timer ??= setTimeout(() => this.#flush(), wait);
  }

  /** Forget what waits. */
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
