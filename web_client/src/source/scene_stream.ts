/**
 * A scene's stream over WebSocket: puts chunk frames together, grants credit as chunks are consumed, and comes back after
 * a broken or silent connection with the list of what it has.
 */

import { parseManifest } from "../codec/manifest";
import type { Manifest } from "../codec/types";
import { Connection, type Socket } from "../protocol/connection";
import {
  CHUNK_FRAME,
  type ClientMessage,
  decodeChunkFrame,
  decodeMessage,
  fromHex,
  MOST_HAVE,
  MOST_PARTS,
  PROTOCOL,
  ProtocolError,
  type ServerMessage,
  toHex,
} from "../protocol/messages";
import { PartialChunks } from "../protocol/partial_chunks";
import { PlayheadMessages } from "../protocol/playhead_messages";
import { fetchChunk } from "./fetch_chunk";
import { continues, grown, type ManifestDocument } from "./growth";
import type { Playhead, SceneSource, SourceEvents, SourceFailure } from "./scene_source";
import { streamFailure } from "./stream_failure";
import { StreamedSound } from "./streamed_sound";
import { Throughput } from "./throughput";

/** Complete chunks that may wait for their decoding before credit is held back, bytes. */
const UNDECODED = 16 << 20;
/** Longest wait before the first retry, ms; doubled at each failure. */
const FIRST_RETRY = 500;
const LAST_RETRY = 8000; // ms
const MOST_PATIENCE = 8;
/** Faults that may pass: the close that follows decides whether to come back. */
const PASSING: ReadonlySet<string> = new Set(["internal", "hello-timeout"]);
/** Closed with one of these, or with 4000 and above, the server would refuse again. */
const FINAL_CODES: ReadonlySet<number> = new Set([1003, 1009]);
const HELLO_TIMEOUT = 4008;
/** The server is told how fast the line is so often at most, ms, and when it has changed by so much. */
const TELL = 1000;
const CHANGE = 1.2;

export class SceneStream implements SceneSource {
  readonly #have = new Set<string>();
  readonly #partial = new PartialChunks();
  readonly #line = new Throughput();
  #told = { at: Number.NEGATIVE_INFINITY, rate: 0 };
  readonly #moves = new PlayheadMessages((message) => this.#send(message));
  #connection: Connection | null = null;
  #chunks: readonly string[] = []; // of the manifest
  #sound = new StreamedSound(new Set(), () => {});
  #document: ManifestDocument | null = null; // the manifest; null while it cannot be read
  /** What has come while a manifest is decompressed. */
  #held: Uint8Array<ArrayBuffer>[] | null = null;
  #manifestId: Uint8Array | null = null;
  #playhead: Playhead;
  #undecoded = 0;
  #failures = 0;
  #patience = 1; // doubled by every silence
  #retry: ReturnType<typeof setTimeout> | undefined; // while there is no connection

  constructor(
    readonly url: string,
    readonly events: SourceEvents,
    playhead: Playhead,
    readonly connect: (url: string) => Socket = (url) => new WebSocket(url),
  ) {
    this.#playhead = playhead;
    this.#connect();
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

  /** The network or the page is back: connect now, or find out whether the connection has survived. */
  wake(): void {
    if (this.#retry !== undefined) this.#connect();
    else this.#connection?.check();
  }

  /** Leave for good. */
  close(): void {
    clearTimeout(this.#retry);
    this.#retry = undefined;
    this.#sound.end();
    this.#leave();
    this.events.state("closed");
  }

  #connect(): void {
    clearTimeout(this.#retry);
    this.#retry = undefined;
    this.events.state("connecting");
    const events = {
      open: (credits: number) => this.#greet(credits),
      message: (bytes: Uint8Array<ArrayBuffer>) => this.#guarded(bytes),
      closed: (code: number) => this.#closed(code),
      silent: () => this.#silent(),
    };
    this.#connection = new Connection(this.connect(this.url), events, this.#patience);
  }

  #greet(credits: number): void {
    this.#moves.clear();
    const { time, rate } = this.#playhead;
    this.#told.rate = 0; // another connection, another server
    const grows = this.#document?.live !== undefined; // then the manifest may have become another one
    const sounds = this.#sound.wanted ? this.#sound.sent : [];
    const named = [...sounds, ...(grows ? this.#have : [])].slice(-MOST_HAVE);
    this.#send({
      type: "hello",
      protocol: PROTOCOL,
      credits,
      ...((grows || this.#sound.wanted) && { have: named.map(fromHex) }),
      have_bits: !grows && this.#chunks.length > 0 ? bitsOf(this.#chunks, this.#have) : undefined,
      codings: ["gzip"],
      parts: this.#partial.keep(MOST_PARTS).map(([id, filled]) => [fromHex(id), filled]),
      ...(this.#manifestId && { manifest_id: this.#manifestId }),
      ...(time !== null && { time }),
      rate,
      ...(this.#sound.wanted && { audio: true }),
      follow: true,
    });
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

  #closed(code: number): void {
    this.#leave();
    const final = FINAL_CODES.has(code) || (code >= 4000 && code !== HELLO_TIMEOUT);
    if (final) this.#fail(streamFailure(code), `the server closed the stream (${code})`);
    else this.#retryLater();
  }

  /** Let go of the connection; it tells nothing any more. */
  #leave(): void {
    this.#connection?.leave();
    this.#connection = null;
    this.#moves.clear();
  }

  /** Nothing has come for too long. A line on which a message takes longer than that is given more time next. */
  #silent(): void {
    this.#patience = Math.min(MOST_PATIENCE, 2 * this.#patience);
    this.#leave();
    this.#retryLater();
  }

  /** Anywhere in a span, so that all viewers of a server that has come back do not come at once. */
  #retryLater(): void {
    this.events.state("retrying");
    const longest = Math.min(LAST_RETRY, FIRST_RETRY * 2 ** this.#failures++);
    this.#retry = setTimeout(() => this.#connect(), longest * Math.random());
  }

  #fail(failure: SourceFailure, detail: string): void {
    this.#sound.end();
    this.#leave();
    this.events.state("closed");
    this.events.failed(failure, detail);
  }

  #send(message: ClientMessage): void {
    this.#connection?.send(message);
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
        this.#open(message.growth, message.coding, (bytes) => this.#grow(bytes, message.manifest_id.slice()));
        break;
      case "missing":
        this.#partial.drop(toHex(message.id));
        if (this.#sound.ids.has(toHex(message.id))) this.#sound.missing(toHex(message.id));
        else this.events.missing(toHex(message.id));
        break;
      case "pong":
        this.#connection?.answered(message.id);
        break;
      case "end":
        if (this.#document?.live === undefined) this.#connection?.rest(); // else there will be more
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
    if (this.#manifestId === null) {
      if (manifest.length === 0) throw new ProtocolError("a welcome has no manifest");
      this.#manifestId = id;
      this.#open(manifest, coding, (bytes) => this.#begin(bytes));
    } else if (!sameBytes(this.#manifestId, id)) {
      if (manifest.length === 0) throw new ProtocolError("a welcome has no manifest");
      this.#open(manifest, coding, (bytes) => this.#become(parse(bytes), id));
    }
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

  #begin(manifest: Uint8Array): void {
    this.#document = parse(manifest);
    this.#chunks = chunksIn(this.#document);
    this.#sound = new StreamedSound(new Set(soundsIn(this.#document)), () => this.#tell());
    this.events.manifest(manifest);
  }

  #grow(growth: Uint8Array, id: Uint8Array): void {
    const added = parse(growth);
    this.#become(this.#document && added && grown(this.#document, added), id);
  }

  /** The manifest has become another one: a later version of the scene, or another scene's. */
  #become(document: ManifestDocument | null, id: Uint8Array): void {
    if (!document || !this.#document || !continues(document, this.#document)) {
      this.#fail("scene-changed", "another manifest than before");
      return;
    }
    let manifest: Manifest;
    try {
      manifest = parseManifest(document);
    } catch (error) {
      this.#fail("not-understood", `the scene has grown into what cannot be read: ${error}`);
      return;
    }
    this.#manifestId = id;
    this.#document = document;
    this.#chunks = chunksIn(document);
    for (const id of soundsIn(document)) this.#sound.ids.add(id);
    this.events.grown(manifest);
  }

  #receiveFrame(message: Uint8Array<ArrayBuffer>): void {
    const frame = decodeChunkFrame(message);
    const chunk = this.#partial.add(frame);
    const sound = this.#sound.ids.has(frame.id);
    if (!sound) this.events.progress(frame.payload.length);
    this.#measure(message.length);
    if (chunk && sound) this.#sound.arrived(frame.id, chunk);
    else if (chunk && !this.#have.has(frame.id)) {
      this.#have.add(frame.id);
      this.#failures = 0; // it moves: the next retry comes soon again
      this.#patience = 1;
      this.#undecoded += chunk.length;
      this.events.chunk(frame.id, chunk);
    }
    this.#grant();
  }

  /** Tell the server how fast the line is: what would come too late can then be left for later. */
  #measure(bytes: number): void {
    const now = performance.now();
    this.#line.count(bytes, now);
    const rate = Math.round(this.#line.rate(now));
    const change = rate / this.#told.rate; // infinite at first
    if (rate === 0 || now - this.#told.at < TELL || (change < CHANGE && change > 1 / CHANGE)) return;
    this.#told = { at: now, rate };
    this.#tell();
  }

  /** What the server should know of this client. */
  #tell(): void {
    const { rate } = this.#told;
    this.#send({ type: "limits", ...(rate > 0 && { measured: rate }), ...(this.#sound.wanted && { audio: true }) });
  }

  /** Give credit back in portions, but not to a decoder that cannot keep up. */
  #grant(): void {
    if (this.#undecoded <= UNDECODED) this.#connection?.grant();
  }
}

/** A manifest, or what is added to one; null for what is none, which the player finds out. */
function parse(bytes: Uint8Array): ManifestDocument | null {
  try {
    const document = JSON.parse(new TextDecoder().decode(bytes));
    return Array.isArray(document?.slices) ? document : null;
  } catch {
    return null;
  }
}

const soundsIn = (document: ManifestDocument | null): string[] => document?.audio?.pieces?.map(({ id }) => id) ?? [];

/** The ids of a manifest's chunks in order; what is no manifest, the player finds out. */
function chunksIn(document: ManifestDocument | null): string[] {
  try {
    const { static: stills = [], slices = [] } = document ?? {};
    return [...stills, ...slices.flatMap((slice) => slice.chunks)].map(({ id }) => id);
  } catch {
    return [];
  }
}

/** Which of the names are there, one bit each, lowest bits first. */
function bitsOf(names: readonly string[], there: ReadonlySet<string>): Uint8Array {
  const bits = new Uint8Array(Math.ceil(names.length / 8));
  for (const [i, name] of names.entries()) if (there.has(name)) bits[i >> 3] |= 1 << (i & 7);
  return bits;
}

/** The address of a chunk on the server of a stream, `ws://host/v1/scenes/{scene}/stream`, with the link that opens both. */
function chunkUrl(stream: string, id: string): string {
  const { search } = new URL(stream);
  return new URL(`../../chunks/${id}${search}`, stream).href.replace(/^ws/, "http");
}

function sameBytes(a: Uint8Array, b: Uint8Array): boolean {
  return a.length === b.length && a.every((byte, i) => byte === b[i]);
}
