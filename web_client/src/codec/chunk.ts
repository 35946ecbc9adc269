/** The container: header, attribute table, streams, checksum (docs/format.md, "Container"). Little endian. */

import { crc32 } from "./crc32";
import { ChunkError } from "./errors";
import { type Bounds, type Box, VERSIONS } from "./types";

const MAGIC = 0x43534748; // "HGSC"
const MAX_SPLATS = 2 ** 20;
const MAX_CHUNK_BYTES = 2 ** 28;
const MAX_ZERO = 2 ** 28;
const ENTRY = 9; // bytes, without its whole numbers of variable length
const CHECKSUM = 4;
const VARINT_BYTES = 5;

/** Byte at which the attribute table begins. */
export const TABLE = 80;

/** A uniform grid: value = (code - zero) * step, one zero per component; in binary64, rounded to binary32. */
export interface Grid {
  readonly bits: number;
  readonly step: number;
  readonly zeros: readonly number[];
}

export interface Plane {
  readonly data: Uint8Array;
  /** Position in the chunk, bytes. */
  readonly at: number;
}

export interface Stream {
  readonly attribute: number;
  readonly transform: number;
  readonly components: number;
  readonly grid: Grid;
  readonly planes: readonly Plane[];
  /** Position of its table entry in the chunk, bytes. */
  readonly at: number;
}

export interface Container {
  readonly version: number;
  readonly kind: "static" | "dynamic";
  readonly count: number;
  readonly timeRange: readonly [number, number];
  readonly box: Box;
  readonly bounds: Bounds;
  readonly streams: readonly Stream[];
}

/** Read header and table, and check every size in them; nothing is decompressed. Throws ChunkError. */
export function unpack(bytes: Uint8Array): Container {
  const length = bytes.length;
  if (length < TABLE + CHECKSUM)
    throw new ChunkError(length, "end of the chunk", `at ${length}`, `at least ${TABLE} + 4`);
  const view = new DataView(bytes.buffer, bytes.byteOffset, length);
  const u32 = (at: number) => view.getUint32(at, true);
  expect(u32(0) === MAGIC, 0, "magic", u32(0), MAGIC);
  expect(VERSIONS.includes(bytes[4]), 4, "version", bytes[4], VERSIONS.join(" or "));
  expect(u32(16) === length, 16, "total length", u32(16), `${length}, the length of the chunk`);
  expect(length <= MAX_CHUNK_BYTES, 16, "total length", length, `at most ${MAX_CHUNK_BYTES}`);
  const actual = crc32(bytes.subarray(0, length - CHECKSUM));
  expect(u32(length - CHECKSUM) === actual, length - CHECKSUM, "checksum", u32(length - CHECKSUM), actual);
  expect(bytes[5] <= 1, 5, "kind", bytes[5], "0 (static) or 1 (dynamic)");
  expect(bytes[7] === 0, 7, "reserved field", bytes[7], 0);
  const count = u32(8);
  expect(count >= 1 && count <= MAX_SPLATS, 8, "splat count", count, `1 to ${MAX_SPLATS}`);
  const corner = (at: number) => [0, 4, 8].map((i) => view.getFloat32(at + i, true)) as [number, number, number];
  const box = { min: corner(20), max: corner(32) };
  const finite = [...box.min, ...box.max].every(Number.isFinite);
  expect(finite && box.min.every((low, i) => low <= box.max[i]), 20, "box", [box.min, box.max], "ascending corners");
  const start = view.getFloat64(44, true);
  const end = view.getFloat64(52, true);
  expect(Number.isFinite(start) && Number.isFinite(end) && start <= end, 44, "time range", [start, end], "ascending");
  const declared = [0, 1, 2, 3, 4].map((i) => view.getFloat32(60 + 4 * i, true));
  expect(
    declared.every((bound) => Number.isFinite(bound) && bound >= 0),
    60,
    "bounds",
    declared,
    "finite, not negative",
  );
  const [position, blur, shape, opacity, rgb] = declared;
  return {
    version: bytes[4],
    kind: bytes[5] === 0 ? "static" : "dynamic",
    count,
    timeRange: [start, end],
    box,
    bounds: { position, blur, shape, opacity, rgb },
    streams: readTable(bytes, view, bytes[6]),
  };
}

function readTable(bytes: Uint8Array, view: DataView, attributes: number): Stream[] {
  const limit = bytes.length - CHECKSUM;
  let at = TABLE;
  const varint = (attribute: number, field: "zero" | "length"): number => {
    let number = 0;
    for (let i = 0; i < VARINT_BYTES; i++) {
      if (at + i >= limit)
        fail(at, `attribute ${attribute} ${field}`, "cut off", `a whole number before byte ${limit}`);
      const byte = bytes[at + i];
      number += (byte & 127) * 2 ** (7 * i);
      if (byte >= 128) continue;
      if (number >= 2 ** 32) fail(at, `attribute ${attribute} ${field}`, number, "below 2^32");
      at += i + 1;
      return number;
    }
    return fail(at, `attribute ${attribute} ${field}`, `longer than ${VARINT_BYTES} bytes`, "below 2^32");
  };
  const entries: { stream: Stream; lengths: number[] }[] = [];
  for (let i = 0; i < attributes; i++) {
    const begin = at;
    if (at + ENTRY > limit) fail(at, `entry ${i}`, "cut off", `${ENTRY} bytes before byte ${limit}`);
    const [attribute, components, bits, transform, planes] = bytes.subarray(at, at + 5);
    if (entries.some(({ stream }) => stream.attribute === attribute))
      fail(at, `attribute ${attribute}`, "a repetition", "each attribute once");
    const step = view.getFloat32(at + 5, true);
    at += ENTRY;
    const zeros: number[] = [];
    for (let c = 0; c < components; c++) {
      const where = at;
      const coded = varint(attribute, "zero");
      const zero = coded % 2 === 0 ? coded / 2 : -(coded + 1) / 2;
      if (Math.abs(zero) > MAX_ZERO) fail(where, `attribute ${attribute} zero`, zero, `at most ${MAX_ZERO} from 0`);
      zeros.push(zero);
    }
    const lengths: number[] = [];
    for (let p = 0; p < planes; p++) lengths.push(varint(attribute, "length"));
    const grid = { bits, step, zeros };
    entries.push({ stream: { attribute, transform, components, grid, planes: [], at: begin }, lengths });
  }
  const streams = entries.map(({ stream, lengths }): Stream => {
    const planes = lengths.map((length): Plane => {
      if (length > limit - at)
        fail(stream.at, `attribute ${stream.attribute} length`, length, `at most ${limit - at}, what is left`);
      at += length;
      return { data: bytes.subarray(at - length, at), at: at - length };
    });
    return { ...stream, planes };
  });
  if (at !== limit) fail(at, "end of the last stream", at, `${limit}, where the checksum begins`);
  return streams;
}

function fail(byte: number, record: string, found: unknown, expected: unknown): never {
  throw new ChunkError(byte, record, found, expected);
}

function expect(condition: boolean, byte: number, record: string, found: unknown, expected: unknown): void {
  if (!condition) fail(byte, record, found, expected);
}
