/**
 * A scene's stream over WebSocket: takes the server's messages, puts chunk frames together, and grants credit as chunks are
 * consumed.
 */

import type { Socket } from "../protocol/connection";
import {
  CHUNK_FRAME,
  type ClientMessage,
  decodeChunkFrame,
  decodeMessage,
  PROTOCOL,
  ProtocolError,
  type ServerMessage,
  toHex,
} from "../protocol/messages";
import { PartialChunks } from "../protocol/partial_chunks";
import { PlayheadMessages } from "../protocol/playhead_messages";
import { chunkUrl, fetchChunk } from "./fetch_chunk";
import { RateReports } from "./rate_reports";
import { ReconnectingSocket } from "./reconnecting_socket";
import type { Playhead, SceneSource, SourceEvents, SourceFailure } from "./scene_source";
import { streamFailure } from "./stream_failure";
import { helloOf } from "./stream_hello";
import { StreamedManifest } from "./streamed_manifest";
import { StreamedSound } from "./streamed_sound";

/** Complete chunks that may wait for their decoding before credit is held back, bytes. */
const UNDECODED = 16 << 20;
/** Faults that may pass: the close that follows decides whether to come back. */
const PASSING: ReadonlySet<string> = new Set(["internal", "hello-timeout"]);

export class SceneStream implements SceneSource {
  readonly #have = new Set<string>();
  readonly #partial = new PartialChunks();
  readonly #rates = new RateReports(() => this.#tell());
  readonly #moves = new PlayheadMessages((message) => this.#send(message));
  readonly #manifest: StreamedManifest;
  readonly #socket: ReconnectingSocket;
  #sound = new StreamedSound(new Set(), () => {});
  /** What has come while a manifest is decompressed. */
  #held: Uint8Array<ArrayBuffer>[] | null = null;
  #playhead: Playhead;
  #undecoded = 0;

  constructor(
    readonly url: string,
    readonly events: SourceEvents,
    playhead: Playhead,
    connect: (url: string) => Socket = (url) => new WebSocket(url),
  ) {
    this.#playhead = playhead;
    this.#manifest = new StreamedManifest({
      grown: (manifest) => {
        for (const id of this.#manifest.sounds) this.#sound.ids.add(id);
        events.grown(manifest);
      },
      failed: (failure, detail) => this.#fail(failure, detail),
    });
    this.#socket = new ReconnectingSocket(() => connect(url), {
      connecting: () => events.state("connecting"),
      open: (credits) => this.#greet(credits),
      message: (bytes) => this.#guarded(bytes),
      retrying: () => {
        this.#moves.clear();
        events.state("retrying");
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

  /** Note where the playhead is, for the next connection; the server keeps its own. */
  playheadAt(time: number): void {
    this.#playhead = { ...this.#playhead, time };
  }

  /** A complete chunk of so many bytes has been decoded. */
  consumed(bytes: number): void {
    this.#undecoded -= bytes;
    this.#grant();
  }

  /** A piece of sound comes with the stream, if it is asked for the first time. */
  async fetchAgain(id: string, signal: AbortSignal, cache?: "reload" | "default"): Promise<Uint8Array<ArrayBuffer>> {
    const streamed = cache === "default" && (await this.#sound.ask(id));
    return streamed || fetchChunk(chunkUrl(this.url, id), signal, cache);
  }

  wake(): void {
    this.#socket.wake();
  }

  /** Leave for good. */
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
    const [playhead, manifest, sound] = [this.#playhead, this.#manifest, this.#sound];
    this.#send(helloOf(credits, { playhead, manifest, sound, have: this.#have, partial: this.#partial }));
  }

  /** What the server should know of this client. */
  #tell(): void {
    const { rate } = this.#rates;
    this.#send({ type: "limits", ...(rate > 0 && { measured: rate }), ...(this.#sound.wanted && { audio: true }) });
  }

  #send(message: ClientMessage): void {
    this.#socket.send(message);
  }

  #guarded(bytes: Uint8Array<ArrayBuffer>): void {
    if (this.#held) {
      this.#held.push(bytes);
      return;
    }
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
        this.#open(message.growth, message.coding, (bytes) => this.#manifest.grow(bytes, message.manifest_id.slice()));
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
        if (!this.#manifest.grows) this.#socket.rest(); // else there will be more
        break;
      case "error":
        if (!PASSING.has(message.code)) this.#fail(streamFailure(message.code), message.detail);
        break;
    }
  }

  #welcome({ protocol, manifest, manifest_id, coding }: Extract<ServerMessage, { type: "welcome" }>): void {
    if (protocol !== PROTOCOL) throw new ProtocolError(`version ${protocol} instead of ${PROTOCOL}`);
    this.events.state("open");
    const id = manifest_id.slice();
    if (this.#manifest.is(id)) return;
    if (manifest.length === 0) throw new ProtocolError("a welcome has no manifest");
    if (this.#manifest.id !== null) {
      this.#open(manifest, coding, (bytes) => this.#manifest.become(bytes, id));
      return;
    }
    this.#manifest.id = id;
    this.#open(manifest, coding, (bytes) => {
      this.#manifest.begin(bytes);
      this.#sound = new StreamedSound(new Set(this.#manifest.sounds), () => this.#tell());
      this.events.manifest(bytes);
    });
  }

  /** Read a manifest, or what has been added to it. */
  #open(bytes: Uint8Array<ArrayBuffer>, coding: string | undefined, read: (bytes: Uint8Array) => void): void {
    if (coding !== undefined && coding !== "gzip") throw new ProtocolError(`a manifest in the coding ${coding}`);
    if (coding) void this.#inflate(bytes, read);
    else read(bytes.slice());
  }

  /** What comes after the manifest waits for it, whatever becomes of the connection. */
  async #inflate(manifest: Uint8Array<ArrayBuffer>, read: (bytes: Uint8Array) => void): Promise<void> {
    const held: Uint8Array<ArrayBuffer>[] = [];
    this.#held = held;
    let bytes: Uint8Array;
    try {
      const stream = new Blob([manifest]).stream().pipeThrough(new DecompressionStream("gzip"));
      bytes = new Uint8Array(await new Response(stream).arrayBuffer());
    } catch {
      this.#fail("not-understood", "the server broke the protocol: the manifest is not gzip");
      return;
    }
    this.#held = null;
    read(bytes);
    for (const message of held) this.#guarded(message);
  }

  #receiveFrame(message: Uint8Array<ArrayBuffer>): void {
    const frame = decodeChunkFrame(message);
    const chunk = this.#partial.add(frame);
    const sound = this.#sound.ids.has(frame.id);
    if (!sound) this.events.progress(frame.payload.length);
    this.#rates.count(message.length, performance.now());
    if (chunk && sound) this.#sound.arrived(frame.id, chunk);
    else if (chunk && !this.#have.has(frame.id)) {
      this.#have.add(frame.id);
      this.#socket.succeeded();
      this.#undecoded += chunk.length;
      this.events.chunk(frame.id, chunk);
    }
    this.#grant();
  }

  /** Give credit back in portions, but not to a decoder that cannot keep up. */
  #grant(): void {
    if (this.#undecoded <= UNDECODED) this.#socket.grant();
  }
}
