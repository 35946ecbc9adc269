/** The container: header, attribute table, streams, checksum (docs/format.md, "Container"). Little endian. */

import { crc32 } from "./crc32";
import { ChunkError } from "./errors";
import type { Box } from "./types";

const MAGIC = 0x43534748; // "HGSC"
const VERSION = 1;
const MAX_SPLATS = 2 ** 20;
const MAX_CHUNK_BYTES = 2 ** 28;
const HEADER = 64;
const ENTRY = 44;
const CHECKSUM = 4;

/** A uniform grid: value = origin + code * step, in binary32. */
export interface Grid {
  readonly bits: number;
  readonly step: number;
  readonly origin: Float32Array;
}

export interface Stream {
  readonly attribute: number;
  readonly quantiser: number;
  readonly transform: number;
  readonly components: number;
  readonly grid: Grid;
  readonly rawBytes: number;
  readonly data: Uint8Array;
  /** Byte of the chunk at which its table entry lies. */
  readonly at: number;
  /** Byte at which its data lies. */
  readonly dataAt: number;
}

export interface Container {
  readonly kind: "static" | "dynamic";
  readonly count: number;
  readonly timeRange: readonly [number, number];
  readonly box: Box;
  readonly streams: readonly Stream[];
}

/** Reads header and table, and checks every size in them; nothing is decompressed. Throws ChunkError. */
export function unpack(bytes: Uint8Array): Container {
  const length = bytes.length;
  if (length < HEADER + CHECKSUM)
    throw new ChunkError(length, "end of the chunk", `at ${length}`, `at least ${HEADER} + 4`);
  const view = new DataView(bytes.buffer, bytes.byteOffset, length);
  const u32 = (at: number) => view.getUint32(at, true);
  expect(u32(0) === MAGIC, 0, "magic", u32(0), MAGIC);
  expect(view.getUint16(4, true) === VERSION, 4, "version", view.getUint16(4, true), VERSION);
  expect(u32(56) === length, 56, "total length", u32(56), `${length}, the length of the chunk`);
  expect(length <= MAX_CHUNK_BYTES, 56, "total length", length, `at most ${MAX_CHUNK_BYTES}`);
  const actual = crc32(bytes.subarray(0, length - CHECKSUM));
  expect(u32(length - CHECKSUM) === actual, length - CHECKSUM, "checksum", u32(length - CHECKSUM), actual);
  const kind = view.getUint8(6);
  expect(kind <= 1, 6, "kind", kind, "0 (static) or 1 (dynamic)");
  const count = u32(8);
  expect(count >= 1 && count <= MAX_SPLATS, 8, "splat count", count, `1 to ${MAX_SPLATS}`);
  const start = view.getFloat64(16, true);
  const end = view.getFloat64(24, true);
  expect(Number.isFinite(start) && Number.isFinite(end) && start <= end, 16, "time range", [start, end], "ascending");
  const corner = (at: number) => [0, 4, 8].map((i) => view.getFloat32(at + i, true)) as [number, number, number];
  const box = { min: corner(32), max: corner(44) };
  const ordered = box.min.every((low, i) => Number.isFinite(low) && Number.isFinite(box.max[i]) && low <= box.max[i]);
  expect(ordered, 32, "box", [box.min, box.max], "finite ascending corners");
  expect(u32(60) === 0, 60, "reserved field", u32(60), 0);
  const streams = readTable(bytes, view, view.getUint8(7));
  return { kind: kind === 0 ? "static" : "dynamic", count, timeRange: [start, end], box, streams };
}

function readTable(bytes: Uint8Array, view: DataView, attributes: number): Stream[] {
  const limit = bytes.length - CHECKSUM;
  let expected = HEADER + ENTRY * attributes;
  expect(expected <= limit, 7, "attribute count", attributes, `at most ${Math.floor((limit - HEADER) / ENTRY)}`);
  const streams: Stream[] = [];
  for (let i = 0; i < attributes; i++) {
    const at = HEADER + ENTRY * i;
    const attribute = view.getUint8(at);
    const record = `attribute ${attribute} (entry ${i})`;
    const reserved = bytes.subarray(at + 5, at + 8);
    expect(
      reserved.every((byte) => byte === 0),
      at + 5,
      `${record} reserved`,
      reserved,
      "zeros",
    );
    expect(
      !streams.some((stream) => stream.attribute === attribute),
      at,
      record,
      "a repetition",
      "each attribute once",
    );
    const offset = view.getUint32(at + 8, true);
    expect(offset === expected, at + 8, `${record} offset`, offset, `${expected}, the end of what precedes it`);
    const length = view.getUint32(at + 12, true);
    expect(length <= limit - offset, at + 12, `${record} length`, length, `at most ${limit - offset}`);
    const numbers = [0, 1, 2, 3, 4, 5].map((n) => view.getFloat32(at + 20 + 4 * n, true));
    expect(numbers.every(Number.isFinite), at + 20, `${record} grid`, numbers, "finite numbers");
    expected = offset + length;
    streams.push({
      attribute,
      quantiser: view.getUint8(at + 1),
      transform: view.getUint8(at + 2),
      components: view.getUint8(at + 3),
      grid: { bits: view.getUint8(at + 4), step: numbers[1], origin: Float32Array.from(numbers.slice(2)) },
      rawBytes: view.getUint32(at + 16, true),
      data: bytes.subarray(offset, expected),
      at,
      dataAt: offset,
    });
  }
  expect(expected === limit, expected, "end of the last stream", expected, `${limit}, where the checksum begins`);
  return streams;
}

function expect(condition: boolean, byte: number, record: string, found: unknown, expected: unknown): void {
  if (!condition) throw new ChunkError(byte, record, found, expected);
}
