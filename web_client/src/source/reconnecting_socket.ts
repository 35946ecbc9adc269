/** The connection of a stream, replaced whenever it breaks or falls silent, unless the server would refuse again. */

import { Connection, type Socket } from "../protocol/connection";
import type { ClientMessage } from "../protocol/messages";
import { retryDelay } from "./download";

const MOST_PATIENCE = 8;
/** Close codes after which the server would refuse again; those from 4000 on are final, too. */
const FINAL_CODES: ReadonlySet<number> = new Set([1003, 1009]);
const HELLO_TIMEOUT = 4008;
const RESTARTING = 1012;

/** The end of a connection that will be replaced: it broke, no message arrived, or the server stops. */
export type Loss = "broken" | "silent" | "restarting";

export interface ReconnectingEvents {
  connecting(): void;
  /** A connection is open: send the hello with this credit. */
  open(credits: number): void;
  message(bytes: Uint8Array<ArrayBuffer>): void;
  /** The connection is lost, and will be replaced. */
  retrying(loss: Loss): void;
  /** The connection is closed for good, by the server with this code. */
  refused(code: number): void;
}

export class ReconnectingSocket {
  #connection: Connection | null = null;
  #failures = 0;
  #patience = 1; // doubled by every silence
  #retry: ReturnType<typeof setTimeout> | undefined; // set while there is no connection

  constructor(
    readonly connect: () => Socket,
    readonly events: ReconnectingEvents,
  ) {
    this.#connect();
  }

  /** Send, if the socket is open. */
  send(message: ClientMessage): void {
    this.#connection?.send(message);
  }

  /** Let the server send as much as the window has room for. */
  grant(): void {
    this.#connection?.grant();
  }

  /** The answer to a ping has arrived. */
  answered(id: number): void {
    this.#connection?.answered(id);
  }

  /** Expect no further data: silence is normal now. */
  rest(): void {
    this.#connection?.rest();
  }

  /** The connection works: the next retry is soon again. */
  succeeded(): void {
    this.#failures = 0;
    this.#patience = 1;
  }

  /** The network or the page is back: connect now, or check that the connection has survived. */
  wake(): void {
    if (this.#retry !== undefined) this.#connect();
    else this.#connection?.check();
  }

  /** Close for good; no event follows. */
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
    else this.#retryLater(code === RESTARTING ? "restarting" : "broken");
  }

  /** Replace a silent connection. A line that is slower than the patience gets more time next. */
  #silent(): void {
    this.#patience = Math.min(MOST_PATIENCE, 2 * this.#patience);
    this.#leave();
    this.#retryLater("silent");
  }

  #retryLater(loss: Loss): void {
    this.events.retrying(loss);
    this.#retry = setTimeout(() => this.#connect(), retryDelay(this.#failures++));
  }

  /** Drop the connection and its events. */
  #leave(): void {
    this.#connection?.leave();
    this.#connection = null;
  }
}
