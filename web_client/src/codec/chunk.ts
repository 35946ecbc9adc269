/** From the bytes of a chunk to float arrays, bit for bit as docs/format.md states. */

import { ATTRIBUTES, type Attribute, type AttributeName, FIFTH, hasRow, planesOf, TURNS } from "./attributes";
import { type Container, type Stream, TABLE, unpack } from "./container";
import { ChunkError } from "./errors";
import { gridPoints } from "./morton";
import { completeQuats, dequantise, ease } from "./quantise";
import { fromPlanes, undoTransform } from "./streams";
import type { DecodedChunk } from "./types";
import { decompress, zstdReady } from "./zstd";

const MAX_BITS = 24;
const MAX_EXPONENT = 20;
/** 2^-100 at 0 to 2^100 at 200: what the largest exponent asks of the fifth order, and less; ** is slow in a loop. */
const POWERS = Float64Array.from({ length: 201 }, (_, i) => 2 ** (i - 100));
const ORDERS = ["velocity", "acceleration", "jerk", "snap", "crackle"] as const;

type Floats = Float32Array<ArrayBuffer>;
type Streams = ReadonlyMap<AttributeName, Stream>;

/** Which splats have rows of an attribute: a list, or all of them. */
type Rows = Map<AttributeName, Uint32Array | "all">;

/** Decodes a chunk. Every size is checked before anything is allocated. Rejects with ChunkError. */
export async function decodeChunk(bytes: Uint8Array): Promise<DecodedChunk> {
  await zstdReady();
  const container = unpack(bytes);
  const { kind, count, timeRange, box, bounds } = container;
  const streams = knownStreams(container);
  const rows = rowsOf(container, streams);
  for (const { name, id } of ATTRIBUTES) {
    const stream = streams.get(name);
    if (rows.has(name) && !stream) throw new ChunkError(TABLE, "attribute table", `without ${name}`, `attribute ${id}`);
    if (stream && name !== "form" && !rows.has(name))
      throw new ChunkError(stream.at, `attribute ${id} (${name})`, "there", "no row of it by the form");
  }
  const reader = new Reader(streams, rows, count);
  const still = kind === "static";
  const positions = reader.read("position");
  const logScales = reader.read("log_scale");
  const rotations = reader.read("rotation", still ? 4 : 3, still ? 1 : 0);
  const opacities = reader.read("opacity");
  const rgb = reader.read("rgb");
  ease(opacities);
  const common = { count, timeRange, box, bounds, logScales, opacities, rgb };
  let chunk: DecodedChunk;
  if (kind === "static") {
    completeQuats(rotations, 4);
    chunk = { kind, ...common, means: positions, quats: rotations };
  } else {
    chunk = { kind, ...common, ...polynomials(reader, positions, rotations) };
  }
  // Of grids that cannot give it, infinity is not looked for.
  const arrays = surelyFinite(streams) ? [] : Object.entries(chunk);
  for (const [name, array] of arrays) {
    if (!(array instanceof Float32Array)) continue;
    const bad = firstNotFinite(array);
    if (bad >= 0)
      throw new ChunkError(
        TABLE,
        `${snake(name)} of splat ${Math.floor((bad * count) / array.length)}`,
        array[bad],
        "finite",
      );
  }
  return chunk;
}

const snake = (name: string): string => name.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`);

/** Whether every value is below 2^27 by its grid, so that times 2^100, the most it can be scaled by, it is finite. */
function surelyFinite(streams: Streams): boolean {
  for (const { grid } of streams.values()) {
    const largest = 2 ** grid.bits + Math.max(...grid.zeros.map(Math.abs));
    if (largest * grid.step >= 2 ** 27) return false;
  }
  return true;
}

/** Index of the first number that is not finite, or -1. */
function firstNotFinite(array: Float32Array): number {
  let sum = 0;
  for (let i = 0; i < array.length; i++) sum += array[i] * 0; // NaN as soon as one is not finite
  return sum === 0 ? -1 : array.findIndex((number) => !Number.isFinite(number));
}

/** The streams of attributes that this version knows, their table entries checked. */
function knownStreams({ version, kind, streams }: Container): Streams {
  const known = new Map<AttributeName, Stream>();
  for (const stream of streams) {
    const attribute = ATTRIBUTES.find(({ id }) => id === stream.attribute);
    if (!attribute || attribute.version > version || (attribute.dynamicOnly && kind === "static")) continue;
    checkEntry(stream, attribute);
    known.set(attribute.name, stream);
  }
  return known;
}

function checkEntry({ at, components, grid, transform, planes }: Stream, attribute: Attribute): void {
  const expect = (condition: boolean, byte: number, field: string, found: unknown, expected: unknown) => {
    if (!condition)
      throw new ChunkError(byte, `attribute ${attribute.id} (${attribute.name}) ${field}`, found, expected);
  };
  const { bits, step } = grid;
  expect(components === attribute.components, at + 1, "components", components, attribute.components);
  expect(bits >= 1 && bits <= MAX_BITS, at + 2, "bits", bits, `1 to ${MAX_BITS}`);
  expect(transform <= attribute.lastTransform, at + 3, "transform", transform, `at most ${attribute.lastTransform}`);
  expect(planes.length === planesOf(attribute, bits), at + 4, "planes", planes.length, planesOf(attribute, bits));
  expect(step > 0 && step < Infinity, at + 5, "step", step, "above 0 and finite");
}

/** Finds which attributes have rows, and which splats those belong to. */
function rowsOf({ version, kind, count }: Container, streams: Streams): Rows {
  const rows: Rows = new Map();
  for (const { name, rowsOf, dynamicOnly } of ATTRIBUTES) {
    if (rowsOf === 0 && name !== "form" && (kind === "dynamic" || !dynamicOnly)) rows.set(name, "all");
  }
  const stream = streams.get("form");
  if (!stream || kind === "static") return rows;
  const [forms] = codesOf(stream, attributeOf("form"), count);
  const largest = TURNS + 3 + (version > 2 ? FIFTH : 0);
  let wrong = 0;
  while (wrong < count && (forms[wrong] < FIFTH || (forms[wrong] <= largest && (forms[wrong] & 3) === 3))) wrong++;
  if (wrong < count)
    throw new ChunkError(
      stream.planes[0].at,
      `form of splat ${wrong}`,
      forms[wrong],
      `at most ${largest}, of order 3 below the fifth`,
    );
  for (const attribute of ATTRIBUTES) {
    if (attribute.rowsOf === 0) continue;
    const members = new Uint32Array(count);
    let found = 0;
    for (let i = 0; i < count; i++) if (hasRow(attribute, forms[i])) members[found++] = i;
    if (found) rows.set(attribute.name, members.subarray(0, found));
  }
  return rows;
}

function attributeOf(name: AttributeName): Attribute {
  return ATTRIBUTES.find((attribute) => attribute.name === name) as Attribute;
}

class Reader {
  constructor(
    readonly streams: Streams,
    readonly rows: Rows,
    readonly count: number,
  ) {}

  /** Values of an attribute, rows of `stride`, its components from `offset` on; no rows if the chunk has none. */
  read(name: AttributeName, stride = attributeOf(name).components, offset = 0): Floats {
    const members = this.rows.get(name);
    const stream = this.streams.get(name);
    if (!members || !stream) return new Float32Array(0);
    const length = members === "all" ? this.count : members.length;
    const values = new Float32Array(length * stride);
    codesOf(stream, attributeOf(name), length).forEach((codes, c) => {
      dequantise(codes, stream.grid, c, values, offset + c, stride);
    });
    return values;
  }
}

/** Codes of each component, checked. */
function codesOf(stream: Stream, attribute: Attribute, rows: number): (Uint8Array | Uint32Array)[] {
  const { bits } = stream.grid;
  const record = `attribute ${attribute.id} (${attribute.name})`;
  const planes = stream.planes.map(({ data, at }, p) => {
    const raw = decompress(data, rows);
    if (!raw) throw new ChunkError(at, `${record} plane ${p}`, "damaged", `a zstd frame of ${rows} bytes`);
    return raw;
  });
  if (attribute.morton) {
    const points = gridPoints(planes, bits);
    if (!points) throw new ChunkError(stream.planes[0].at, `${record} codes`, "beyond the grid", `below 2^${3 * bits}`);
    return points;
  }
  const codes = fromPlanes(planes, bits);
  if (bits % 8 !== 0) {
    codes.forEach((component, c) => {
      const each = Math.ceil(bits / 8);
      if (allBits(planes[c * each + each - 1]) < 2 ** (bits % 8)) return; // what is too large shows in the last plane
      let splat = 0;
      for (let i = 1; i < component.length; i++) if (component[i] > component[splat]) splat = i;
      const { at } = stream.planes[c * each];
      throw new ChunkError(at, `${record} code of row ${splat}`, component[splat], `below 2^${bits}`);
    });
  }
  undoTransform(codes, bits, stream.transform);
  return codes;
}

/** Every bit that a byte of the plane has. */
function allBits(plane: Uint8Array): number {
  let seen = 0;
  const whole = plane.byteOffset % 4 === 0 ? plane.length >> 2 : 0;
  const words = new Uint32Array(plane.buffer, whole ? plane.byteOffset : 0, whole);
  for (let i = 0; i < whole; i++) seen |= words[i]; // four bytes at once
  for (let i = 4 * whole; i < plane.length; i++) seen |= plane[i];
  return (seen | (seen >>> 8) | (seen >>> 16) | (seen >>> 24)) & 255;
}

/** Puts the polynomials of a dynamic chunk together, and undoes their scaling by powers of two. */
function polynomials(reader: Reader, positions: Floats, rotations: Floats) {
  const { count } = reader;
  const timeCenters = reader.read("time_center");
  const timeLogPrecisions = reader.read("time_log_precision");
  const higher = ORDERS.map((name) => reader.read(name));
  const turning = reader.read("turning");
  const bad = firstNotFinite(timeLogPrecisions);
  if (bad >= 0)
    throw new ChunkError(TABLE, `time_log_precision of splat ${bad}`, timeLogPrecisions[bad], "a finite number");
  // About the reciprocal of the time for which a splat can be seen is 2^e.
  const exponents = new Uint8Array(count);
  for (let i = 0; i < count; i++) {
    const exact = Math.floor((timeLogPrecisions[i] - 1.75) * 0.7213475204444817);
    exponents[i] = Math.min(MAX_EXPONENT, Math.max(0, exact));
    timeCenters[i] *= POWERS[100 - exponents[i]];
  }
  const width = reader.rows.has("crackle") ? 18 : 12;
  const motion = new Float32Array(count * width);
  const rotation = new Float32Array(count * 8);
  for (let i = 0; i < count; i++) {
    for (let c = 0; c < 3; c++) {
      motion[width * i + c] = positions[3 * i + c];
      rotation[8 * i + 1 + c] = rotations[3 * i + c];
    }
  }
  const place = (
    name: AttributeName,
    values: Floats,
    components: number,
    to: Floats,
    stride: number,
    order: number,
  ) => {
    const members = reader.rows.get(name);
    if (!members || members === "all") return;
    for (let row = 0; row < members.length; row++) {
      const power = POWERS[100 + order * exponents[members[row]]];
      const at = members[row] * stride + order * components;
      for (let c = 0; c < components; c++) to[at + c] = values[row * components + c] * power;
    }
  };
  for (let k = 0; k < ORDERS.length; k++) place(ORDERS[k], higher[k], 3, motion, width, k + 1);
  place("turning", turning, 4, rotation, 8, 1);
  completeQuats(rotation, 8);
  return { motion, rotation, timeCenters, timeLogPrecisions };
}
