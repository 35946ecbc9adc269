/** One WebSocket to the server, with its credit and its detection of a dead line. */

import { CreditWindow } from "./credit_window";
import { LineWatch } from "./line_watch";
import { CHUNK_FRAME, type ClientMessage, encodeMessage } from "./messages";

/** Ids of pings: for measurements of the line, and for checks of the server. */
const MEASURE = 1;
const ASK = 0;

/** The part of WebSocket in use, so that tests can provide their own. */
export interface Socket {
  binaryType: BinaryType;
  onopen: ((event: Event) => void) | null;
  onmessage: ((event: MessageEvent) => void) | null;
  onclose: ((event: CloseEvent) => void) | null;
  send(data: Uint8Array<ArrayBuffer>): void;
  close(code?: number): void;
}

export interface ConnectionEvents {
  /** Send the hello with this credit. */
  open(credits: number): void;
  message(bytes: Uint8Array<ArrayBuffer>): void;
  closed(code: number): void;
  /** No message has arrived for too long. */
  silent(): void;
}

export class Connection {
  readonly #watch: LineWatch;
  #window: CreditWindow | null = null; // null until the socket is open

  /**
   * Connect.
   *
   * @param patience factor of the usual time before a line counts as dead.
   */
  constructor(
    readonly socket: Socket,
    events: ConnectionEvents,
    patience: number,
  ) {
    const start = performance.now();
    this.#watch = new LineWatch(() => this.send({ type: "ping", id: ASK }), events.silent, patience);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.#watch.received();
      const now = performance.now();
      this.#window = new CreditWindow(now - start, now); // the upgrade has taken a round trip, at least
      events.open(this.#window.grant());
      this.send({ type: "ping", id: MEASURE });
    };
    socket.onmessage = ({ data }) => {
      this.#watch.received();
      const bytes = new Uint8Array(data as ArrayBuffer);
      if (bytes[0] === CHUNK_FRAME && this.#window?.received(bytes.length, performance.now())) {
        this.send({ type: "ping", id: MEASURE });
      }
      events.message(bytes);
    };
    socket.onclose = ({ code }) => events.closed(code);
  }

  /** Send, if the socket is open. */
  send(message: ClientMessage): void {
    if (this.#window) this.socket.send(encodeMessage(message));
  }

  /** Let the server send as much as the window has room for. */
  grant(): void {
    const bytes = this.#window?.grant() ?? 0;
    if (bytes > 0) this.send({ type: "credit", bytes });
  }

  /** The answer to a ping has arrived. */
  answered(id: number): void {
    if (id === MEASURE) this.#window?.answered(performance.now());
  }

  /** Check whether the connection is alive. */
  check(): void {
    this.#watch.check();
  }

  /** Expect no further data: silence is normal now. */
  rest(): void {
    this.#watch.stop();
  }

  /** Close the connection; no event follows. */
  leave(): void {
    this.#watch.stop();
    this.socket.onopen = this.socket.onmessage = this.socket.onclose = null;
    this.socket.close(1000);
  }
}
