/**
 * A scene's stream over WebSocket: puts chunk frames together, grants credit as chunks are consumed, and comes back after
 * a broken connection with the list of what it has.
 */

import {
  CHUNK_FRAME,
  type ClientMessage,
  decodeChunkFrame,
  decodeMessage,
  encodeMessage,
  fromHex,
  PROTOCOL,
  ProtocolError,
} from "./messages";

/** First grant, bytes: fills 50 Mbit/s at 300 ms, and a seek waits behind no more than this. */
const WINDOW = 2 << 20;
/** Complete chunks that may wait for their decoding before credit is held back, bytes. */
const UNDECODED = 16 << 20;
const FIRST_RETRY = 500; // ms, doubled at each failure
const LAST_RETRY = 8000; // ms

export type StreamState = "connecting" | "open" | "retrying" | "closed";

export interface StreamEvents {
  /** The manifest's bytes; once. */
  manifest(bytes: Uint8Array): void;
  /** A complete chunk; call `consumed` with its size when it is done with. */
  chunk(id: string, bytes: Uint8Array<ArrayBuffer>): void;
  /** Chunk bytes arrived, headers not counted. */
  progress(bytes: number): void;
  state(state: StreamState): void;
  /** The stream is over for a reason that coming back does not cure; one line for people. */
  failed(message: string): void;
}

interface Playhead {
  readonly time: number | null; // seconds; null for the scene's start
  readonly rate: number; // 0 while paused
}

/** As much of WebSocket as is used, so that tests can bring their own. */
export interface Socket {
  binaryType: BinaryType;
  onopen: ((event: Event) => void) | null;
  onmessage: ((event: MessageEvent) => void) | null;
  onclose: ((event: CloseEvent) => void) | null;
  send(data: Uint8Array<ArrayBuffer>): void;
  close(code?: number): void;
}

export class SceneStream {
  readonly #have = new Set<string>();
  readonly #partial = new Map<string, { bytes: Uint8Array<ArrayBuffer>; filled: number }>();
  #socket: Socket | null = null;
  #manifest: Uint8Array | null = null;
  #playhead: Playhead;
  #open = false;
  #owed = 0; // credit to grant
  #undecoded = 0;
  #failures = 0;
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    readonly url: string,
    readonly events: StreamEvents,
    playhead: Playhead,
    readonly connect: (url: string) => Socket = (url) => new WebSocket(url),
  ) {
    this.#playhead = playhead;
    this.#connect();
  }

  seek(time: number): void {
    this.#playhead = { ...this.#playhead, time };
    this.#send({ type: "seek", time });
  }

  play(time: number, rate: number): void {
    this.#playhead = { time, rate };
    this.#send({ type: "play", time, rate });
  }

  pause(time: number): void {
    this.#playhead = { time, rate: 0 };
    this.#send({ type: "pause", time });
  }

  /** Note where the playhead is, for the next connection; the server keeps its own. */
  playheadAt(time: number): void {
    this.#playhead = { ...this.#playhead, time };
  }

  /** A complete chunk of so many bytes has been decoded. */
  consumed(bytes: number): void {
    this.#undecoded -= bytes;
    this.#grant();
  }

  /** Leave for good. */
  close(): void {
    clearTimeout(this.#timer);
    const socket = this.#socket;
    this.#detach();
    socket?.close(1000);
    this.events.state("closed");
  }

  #connect(): void {
    this.events.state("connecting");
    const socket = this.connect(this.url);
    this.#socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.#open = true;
      this.#owed = 0;
      const { time, rate } = this.#playhead;
      const have = Array.from(this.#have, fromHex);
      const hello: ClientMessage = { type: "hello", protocol: PROTOCOL, credits: WINDOW, have, rate };
      this.#send(time === null ? hello : { ...hello, time });
    };
    socket.onmessage = ({ data }) => {
      try {
        this.#receive(new Uint8Array(data as ArrayBuffer));
      } catch (error) {
        if (!(error instanceof ProtocolError)) throw error;
        this.#fail(`the server broke the protocol: ${error.message}`);
      }
    };
    socket.onclose = ({ code }) => {
      this.#detach();
      if (code >= 4000 || code === 1003 || code === 1009) this.#fail(`the server closed the stream (${code})`);
      else this.#retry();
    };
  }

  #detach(): void {
    if (this.#socket) this.#socket.onopen = this.#socket.onmessage = this.#socket.onclose = null;
    this.#socket = null;
    this.#open = false;
    this.#partial.clear(); // a new connection sends them from the start
  }

  #retry(): void {
    this.events.state("retrying");
    const wait = Math.min(LAST_RETRY, FIRST_RETRY * 2 ** this.#failures++);
    this.#timer = setTimeout(() => this.#connect(), wait * (0.75 + 0.5 * Math.random()));
  }

  #fail(message: string): void {
    const socket = this.#socket;
    this.#detach();
    socket?.close(1000);
    this.events.state("closed");
    this.events.failed(message);
  }

  #send(message: ClientMessage): void {
    if (this.#open) this.#socket?.send(encodeMessage(message));
  }

  #receive(bytes: Uint8Array<ArrayBuffer>): void {
    if (bytes[0] === CHUNK_FRAME) {
      this.#receiveFrame(bytes);
      return;
    }
    const message = decodeMessage(bytes);
    if (message?.type === "welcome") this.#welcome(message.protocol, message.manifest);
    // Faults of the server may pass: the close that follows decides whether to come back.
    if (message?.type === "error" && message.code !== "internal") this.#fail(message.detail);
  }

  #welcome(protocol: number, manifest: Uint8Array): void {
    if (protocol !== PROTOCOL) throw new ProtocolError(`version ${protocol} instead of ${PROTOCOL}`);
    this.events.state("open");
    if (this.#manifest === null) {
      this.#manifest = manifest.slice();
      this.events.manifest(this.#manifest);
    } else if (!sameBytes(this.#manifest, manifest)) {
      this.#fail("the scene has been published anew; load the page again");
    }
  }

  #receiveFrame(message: Uint8Array<ArrayBuffer>): void {
    const { id, offset, size, payload } = decodeChunkFrame(message);
    const partial = this.#partial.get(id) ?? { bytes: new Uint8Array(size), filled: 0 };
    if (offset !== partial.filled || size !== partial.bytes.length) {
      throw new ProtocolError(`chunk ${id.slice(0, 12)}: byte ${offset} of ${size} came after ${partial.filled}`);
    }
    partial.bytes.set(payload, offset);
    partial.filled += payload.length;
    this.#owed += message.length;
    this.events.progress(payload.length);
    if (partial.filled < size) {
      this.#partial.set(id, partial);
    } else {
      this.#partial.delete(id);
      this.#have.add(id);
      this.#failures = 0; // it moves: the next retry comes soon again
      this.#undecoded += size;
      this.events.chunk(id, partial.bytes);
    }
    this.#grant();
  }

  /** Give credit back in portions, but not to a decoder that cannot keep up. */
  #grant(): void {
    if (this.#undecoded > UNDECODED || this.#owed < WINDOW / 8) return;
    this.#send({ type: "credit", bytes: this.#owed });
    this.#owed = 0;
  }
}

function sameBytes(a: Uint8Array, b: Uint8Array): boolean {
  return a.length === b.length && a.every((byte, i) => byte === b[i]);
}
