/**
 * The source for a stream over WebSocket: handles the server's messages, joins chunk frames, and grants credit as
 * chunks are consumed.
 */

import { toHex } from "../codec/hex";
import type { Socket } from "../protocol/connection";
import {
  CHUNK_FRAME,
  type ClientMessage,
  decodeChunkFrame,
  decodeMessage,
  PROTOCOL,
  ProtocolError,
  type ServerMessage,
} from "../protocol/messages";
import { PartialChunks } from "../protocol/partial_chunks";
import { PlayheadMessages } from "../protocol/playhead_messages";
import { chunkUrl, fetchChunk } from "./fetch_chunk";
import { MessageOrder } from "./message_order";
import { continues, readIndex } from "./paged_manifest";
import { RateReports } from "./rate_reports";
import { ReconnectingSocket } from "./reconnecting_socket";
import type { Playhead, SceneManifest, SceneSource, SourceEvents, SourceFailure } from "./scene_source";
import { helloOf } from "./stream_hello";
import { StreamedSound, soundsOf } from "./streamed_sound";

/** Bytes of complete chunks waiting for the decoder before credit is held back. */
const UNDECODED = 16 << 20;
/** Errors that may pass: the close code that follows decides about a retry. */
const PASSING: ReadonlySet<string> = new Set(["internal", "hello-timeout"]);

export class SceneStream implements SceneSource {
  readonly #have = new Set<string>();
  readonly #partial = new PartialChunks();
  readonly #rates = new RateReports(() => this.#sendLimits());
  readonly #moves = new PlayheadMessages((message) => this.#send(message));
  readonly #socket: ReconnectingSocket;
  #sound = new StreamedSound(new Set(), () => {});
  #scene: SceneManifest | null = null; // null until the index has arrived
  #id: Uint8Array | null = null; // id of the index
  readonly #messages = new MessageOrder<Uint8Array<ArrayBuffer>>(
    (bytes) => this.#guarded(bytes),
    (error) => this.#fail("unreadable", String(error)),
  );
  #playhead: Playhead;
  #undecoded = 0;
  #welcomed = false;
  #restarting = false; // a stop announced by the server, until its next welcome

  constructor(
    readonly url: string,
    readonly events: SourceEvents,
    playhead: Playhead,
    connect: (url: string) => Socket = (url) => new WebSocket(url),
    /** Called when a connection has failed and none has brought a welcome so far; `silent` if it did not even end. */
    unwelcome: (silent: boolean) => void = () => {},
  ) {
    this.#playhead = playhead;
    this.#socket = new ReconnectingSocket(() => connect(url), {
      connecting: () => events.state(this.#restarting ? "restarting" : "connecting"),
      open: (credits) => this.#greet(credits),
      message: (bytes) => this.#messages.put(bytes),
      retrying: (loss) => {
        this.#moves.clear();
        this.#restarting ||= loss === "restarting";
        events.state(this.#restarting ? "restarting" : "retrying");
        if (!this.#welcomed) unwelcome(loss === "silent");
      },
      refused: (code) => this.#fail(streamFailure(code), `the server closed the stream (${code})`),
    });
  }

  seek(time: number): void {
    this.#playhead = { ...this.#playhead, time };
    this.#moves.put({ type: "seek", time });
  }

  play(time: number, rate: number): void {
    this.#playhead = { time, rate };
    this.#moves.put({ type: "play", time, rate });
  }

  pause(time: number): void {
    this.#playhead = { time, rate: 0 };
    this.#moves.put({ type: "pause", time });
  }

  /** Note the playhead's place, for the next connection; the server keeps its own. */
  playheadAt(time: number): void {
    this.#playhead = { ...this.#playhead, time };
  }

  /** Report that a complete chunk of this size has been decoded. */
  consumed(bytes: number): void {
    this.#undecoded -= bytes;
    this.#grant();
  }

  /** A piece of sound arrives with the stream when it is requested for the first time. */
  async fetchAgain(id: string, signal: AbortSignal, cache?: "reload" | "default"): Promise<Uint8Array<ArrayBuffer>> {
    const streamed = cache === "default" && (await this.#sound.ask(id));
    return streamed || fetchChunk(chunkUrl(this.url, id), signal, cache);
  }

  wake(): void {
    this.#socket.wake();
  }

  /** Close for good. */
  close(): void {
    this.#sound.end();
    this.#moves.clear();
    this.#socket.close();
    this.events.state("closed");
  }

  #fail(failure: SourceFailure, detail: string): void {
    this.close();
    this.events.failed(failure, detail);
  }

  #greet(credits: number): void {
    this.#moves.clear();
    this.#rates.forget();
    const [playhead, id, sound] = [this.#playhead, this.#id, this.#sound];
    const pages = this.#scene?.listed?.() ?? [];
    this.#send(helloOf(credits, { playhead, id, pages, sound, have: this.#have, partial: this.#partial }));
  }

  /** Send the server the client's state. */
  #sendLimits(): void {
    const { rate } = this.#rates;
    this.#send({ type: "limits", ...(rate > 0 && { measured: rate }), ...(this.#sound.wanted && { audio: true }) });
  }

  #send(message: ClientMessage): void {
    this.#socket.send(message);
  }

  #guarded(bytes: Uint8Array<ArrayBuffer>): void {
    try {
      this.#receive(bytes);
    } catch (error) {
      if (!(error instanceof ProtocolError)) throw error;
      this.#fail("not-understood", `the server broke the protocol: ${error.message}`);
    }
  }

  #receive(bytes: Uint8Array<ArrayBuffer>): void {
    if (bytes[0] === CHUNK_FRAME) {
      this.#receiveFrame(bytes);
      return;
    }
    const message = decodeMessage(bytes);
    switch (message?.type) {
      case "welcome":
        this.#welcome(message);
        break;
      case "grow":
        this.#become(message);
        break;
      case "missing":
        this.#partial.drop(toHex(message.id));
        if (this.#sound.ids.has(toHex(message.id))) this.#sound.missing(toHex(message.id));
        else this.events.missing(toHex(message.id));
        break;
      case "pong":
        this.#socket.answered(message.id);
        break;
      case "end":
        if (!this.#scene?.manifest.live) this.#socket.rest(); // a growing scene has more to send
        break;
      case "error":
        if (!PASSING.has(message.code)) this.#fail(streamFailure(message.code), message.detail);
        break;
    }
  }

  #welcome(message: Extract<ServerMessage, { type: "welcome" }>): void {
    const { protocol, manifest, manifest_id } = message;
    if (protocol !== PROTOCOL) throw new ProtocolError(`version ${protocol} instead of ${PROTOCOL}`);
    this.#welcomed = true;
    this.#restarting = false;
    this.events.state("open");
    if (this.#id?.every((byte, i) => byte === manifest_id[i])) return;
    if (manifest.length === 0) throw new ProtocolError("a welcome has no manifest");
    this.#become(message);
  }

  /** Continue with an index: the first one, or that of the grown scene. */
  #become({ manifest, manifest_id }: Pick<Extract<ServerMessage, { type: "grow" }>, "manifest" | "manifest_id">): void {
    const before = this.#scene;
    const id = manifest_id.slice();
    this.#messages.read(
      () => readIndex(manifest.slice(), before ?? undefined),
      (scene) => {
        if (before && !continues(scene, before)) {
          this.#fail("scene-changed", "another manifest than before");
          return;
        }
        this.#scene = scene;
        this.#id = id;
        if (before) {
          this.#grown();
        } else {
          this.#sound = new StreamedSound(soundsOf(scene.manifest), () => this.#sendLimits());
          this.events.manifest(scene.manifest);
        }
      },
    );
  }

  #grown(): void {
    if (!this.#scene) return;
    const { manifest } = this.#scene;
    for (const id of soundsOf(manifest)) this.#sound.ids.add(id);
    this.events.grown(manifest);
  }

  #receiveFrame(message: Uint8Array<ArrayBuffer>): void {
    const frame = decodeChunkFrame(message);
    const chunk = this.#partial.add(frame);
    const { id } = frame;
    const sound = this.#sound.ids.has(id);
    const page = this.#scene?.lacks?.(id);
    if (!sound && !page) this.events.progress(frame.payload.length);
    this.#rates.count(message.length, performance.now());
    if (chunk && sound) this.#sound.arrived(id, chunk);
    else if (chunk && page) this.#addPage(id, chunk);
    else if (chunk && !this.#have.has(id)) {
      this.#have.add(id);
      this.#socket.succeeded();
      this.#undecoded += chunk.length;
      this.events.chunk(id, chunk);
    }
    this.#grant();
  }

  /** A damaged page is fetched once more, and then given up. */
  #addPage(id: string, bytes: Uint8Array<ArrayBuffer>): void {
    const { signal } = new AbortController();
    const again = async () => this.#scene?.add?.(id, await fetchChunk(chunkUrl(this.url, id), signal));
    this.#messages.read(
      () =>
        this.#scene
          ?.add?.(id, bytes)
          .catch(again)
          .catch(() => this.events.missing(id)),
      () => this.#grown(),
    );
  }

  /** Return credit in portions, but not while the decoder lags. */
  #grant(): void {
    if (this.#undecoded <= UNDECODED) this.#socket.grant();
  }
}

/** The server's error codes, and the close codes without one (docs/stream.md, Closing). */
const MEANINGS: Readonly<Record<string | number, SourceFailure>> = {
  "scene-not-found": "no-scene",
  4004: "no-scene",
  "scene-changed": "scene-changed",
  "access-ended": "access-ended",
  4003: "access-ended",
  "protocol-unsupported": "not-understood",
  4001: "not-understood",
  malformed: "not-understood",
  4000: "not-understood",
  "not-binary": "not-understood",
  1003: "not-understood",
  "message-too-large": "not-understood",
  1009: "not-understood",
  "credit-overflow": "not-understood",
  4009: "not-understood",
  flood: "ended",
};

/**
 * The failure for an error.
 *
 * @param code of an `error` message or of a close
 */
export function streamFailure(code: string | number): SourceFailure {
  return Object.hasOwn(MEANINGS, code) ? MEANINGS[code] : "ended";
}
