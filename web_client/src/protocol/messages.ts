/** The messages of docs/stream.md: one encoder, one decoder, and the chunk frame. */

import { toHex } from "../codec/hex";
import { pack, unpack } from "./msgpack";

export const PROTOCOL = 1;
export const CHUNK_FRAME = 0x01;
export const CHUNK_HEADER_BYTES = 48;
/** Most entries of a list in a hello. */
export const MOST_PARTS = 1024;
export const MOST_HAVE = 16384;

export type ClientMessage =
  | {
      type: "hello";
      protocol: number;
      credits: number;
      /** Chunks that the client has, except those of `pages`. */
      have?: Uint8Array[];
      /** Pages of the manifest that the client has, with one bit per listed chunk that it has, lowest bits first. */
      pages?: [Uint8Array, Uint8Array][];
      /** Chunks with only their first bytes, and the number of these. */
      parts: [Uint8Array, number][];
      /** SHA-256 of the client's index. */
      manifest_id?: Uint8Array;
      time?: number;
      rate: number;
      splats?: number;
      bytes_per_second?: number;
      /** Whether to send additions to a growing scene. */
      follow?: boolean;
      /** Whether to send the scene's sound, too. */
      audio?: boolean;
    }
  | { type: "credit"; bytes: number }
  | { type: "seek"; time: number }
  | { type: "play"; time: number; rate: number }
  | { type: "pause"; time: number }
  /** The client's limits from now on; absent ones are infinite or unknown. */
  | { type: "limits"; splats?: number; bytes_per_second?: number; measured?: number; audio?: boolean }
  | { type: "ping"; id: number };

export type ServerMessage =
  | {
      type: "welcome";
      protocol: number;
      scene: string;
      /** The index; empty if the hello contained its id. */
      manifest: Uint8Array<ArrayBuffer>;
      /** SHA-256 of the index. */
      manifest_id: Uint8Array;
      remaining: number;
    }
  /** The scene has grown: its new index. */
  | { type: "grow"; manifest: Uint8Array<ArrayBuffer>; manifest_id: Uint8Array; remaining: number }
  /** The server cannot give the chunk. */
  | { type: "missing"; id: Uint8Array }
  /** Layer 0: the base of a slice has been sent; layer 1: all of it. */
  | { type: "slice"; index: number; start: number; end: number; layer: number }
  | { type: "pong"; id: number }
  | { type: "end"; bytes: number; left_out: number }
  | { type: "error"; code: string; detail: string };

/** A piece of a chunk; the payload is a view into the message. */
export interface ChunkFrame {
  readonly id: string; // SHA-256, hex
  readonly offset: number;
  readonly size: number; // size of the whole chunk
  readonly payload: Uint8Array<ArrayBuffer>;
}

/** Error for a message that violates the protocol. */
export class ProtocolError extends Error {}

export function encodeMessage(message: ClientMessage): Uint8Array<ArrayBuffer> {
  return pack(message);
}

const FIELDS: Readonly<Record<ServerMessage["type"], Readonly<Record<string, "number" | "string" | "bytes">>>> = {
  welcome: { protocol: "number", scene: "string", manifest: "bytes", manifest_id: "bytes", remaining: "number" },
  grow: { manifest: "bytes", manifest_id: "bytes", remaining: "number" },
  missing: { id: "bytes" },
  slice: { index: "number", start: "number", end: "number" },
  pong: { id: "number" },
  end: { bytes: "number" },
  error: { code: "string", detail: "string" },
};

/**
 * Decode a control message; null for a type unknown to this version, which is ignored.
 *
 * @throws ProtocolError if the bytes are no message or a field is missing or of the wrong type.
 */
export function decodeMessage(bytes: Uint8Array): ServerMessage | null {
  let value: unknown;
  try {
    value = unpack(bytes);
  } catch (error) {
    throw new ProtocolError(`a message is not msgpack: ${error instanceof Error ? error.message : error}`);
  }
  if (typeof value !== "object" || value === null || Array.isArray(value)) {
    throw new ProtocolError("a message is not a map");
  }
  const message = value as Record<string, unknown>;
  if (typeof message.type !== "string") throw new ProtocolError("a message has no type");
  if (!Object.hasOwn(FIELDS, message.type)) return null;
  const fields = FIELDS[message.type as ServerMessage["type"]];
  for (const [name, kind] of Object.entries(fields)) {
    const field = message[name];
    const right = kind === "bytes" ? field instanceof Uint8Array : typeof field === kind;
    if (!right) throw new ProtocolError(`message ${message.type}: field ${name} is not ${kind}`);
  }
  return message as ServerMessage;
}

/**
 * Decode a chunk frame.
 *
 * @throws ProtocolError if it is truncated or outside its chunk.
 */
export function decodeChunkFrame(bytes: Uint8Array<ArrayBuffer>): ChunkFrame {
  if (bytes.length <= CHUNK_HEADER_BYTES) throw new ProtocolError(`a chunk frame of ${bytes.length} bytes is cut off`);
  const header = new DataView(bytes.buffer, bytes.byteOffset, CHUNK_HEADER_BYTES);
  const offset = header.getUint32(4, true);
  const size = header.getUint32(8, true);
  const payload = bytes.subarray(CHUNK_HEADER_BYTES);
  if (offset + payload.length > size) {
    throw new ProtocolError(`a chunk frame ends at byte ${offset + payload.length} of ${size}`);
  }
  return { id: toHex(bytes.subarray(16, CHUNK_HEADER_BYTES)), offset, size, payload };
}
