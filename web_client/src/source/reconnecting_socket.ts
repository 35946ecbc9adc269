/** The connection of a stream: another one in place of each that broke or fell silent, unless the server would refuse again. */

import { Connection, type Socket } from "../protocol/connection";
import type { ClientMessage } from "../protocol/messages";
import { retryDelay } from "./download";

const MOST_PATIENCE = 8;
/** Closed with one of these, or with 4000 and above, the server would refuse again. */
const FINAL_CODES: ReadonlySet<number> = new Set([1003, 1009]);
const HELLO_TIMEOUT = 4008;

export interface ReconnectingEvents {
  connecting(): void;
  /** A connection is there: say hello with so much credit. */
  open(credits: number): void;
  message(bytes: Uint8Array<ArrayBuffer>): void;
  /** It is gone, and another one comes later; `silent` if it has not ended, but nothing has come. */
  retrying(silent: boolean): void;
  /** It is gone for good, closed by the server with this code. */
  refused(code: number): void;
}

export class ReconnectingSocket {
  #connection: Connection | null = null;
  #failures = 0;
  #patience = 1; // doubled by every silence
  #retry: ReturnType<typeof setTimeout> | undefined; // while there is no connection

  constructor(
    readonly connect: () => Socket,
    readonly events: ReconnectingEvents,
  ) {
    this.#connect();
  }

  /** Send, if it is open. */
  send(message: ClientMessage): void {
    this.#connection?.send(message);
  }

  /** Let the server send as much as there is room for. */
  grant(): void {
    this.#connection?.grant();
  }

  /** A ping has been answered. */
  answered(id: number): void {
    this.#connection?.answered(id);
  }

  /** Nothing is waited for any more: silence is right. */
  rest(): void {
    this.#connection?.rest();
  }

  /** It brings what it should: the next retry comes soon again. */
  succeeded(): void {
    this.#failures = 0;
    this.#patience = 1;
  }

  /** The network or the page is back: connect now, or find out whether the connection has survived. */
  wake(): void {
    if (this.#retry !== undefined) this.#connect();
    else this.#connection?.check();
  }

  /** Leave for good; no event comes any more. */
  close(): void {
    clearTimeout(this.#retry);
    this.#retry = undefined;
    this.#leave();
  }

  #connect(): void {
    clearTimeout(this.#retry);
    this.#retry = undefined;
    this.events.connecting();
    const events = {
      open: (credits: number) => this.events.open(credits),
      message: (bytes: Uint8Array<ArrayBuffer>) => this.events.message(bytes),
      closed: (code: number) => this.#closed(code),
      silent: () => this.#silent(),
    };
    this.#connection = new Connection(this.connect(), events, this.#patience);
  }

  #closed(code: number): void {
    this.#leave();
    const final = FINAL_CODES.has(code) || (code >= 4000 && code !== HELLO_TIMEOUT);
    if (final) this.events.refused(code);
    else this.#retryLater(false);
  }

  /** Nothing has come for too long. A line on which a message takes longer than that is given more time next. */
  #silent(): void {
    this.#patience = Math.min(MOST_PATIENCE, 2 * this.#patience);
    this.#leave();
    this.#retryLater(true);
  }

  #retryLater(silent: boolean): void {
    this.events.retrying(silent);
    this.#retry = setTimeout(() => this.#connect(), retryDelay(this.#failures++));
  }

  /** Let go of the connection; it tells nothing any more. */
  #leave(): void {
    this.#connection?.leave();
    this.#connection = null;
  }
}
