/** From the bytes of a chunk to float arrays, bit for bit as docs/format.md states. */

import { ATTRIBUTES, type Attribute, type AttributeName, planesOf, QUANTISER, TRANSFORM } from "./attributes";
import { type Stream, unpack } from "./container";
import { ChunkError } from "./errors";
import { gridPoints } from "./morton";
import { dequantise, quatsFromSmallestThree } from "./quantise";
import { fromPlanes, undoTransform } from "./streams";
import type { DecodedChunk } from "./types";
import { decompress, zstdReady } from "./zstd";

const MAX_BITS = 24;
const MAX_EXPONENT = 40;
const POWERS = Array.from({ length: 6 * MAX_EXPONENT + 1 }, (_, i) => 2 ** (i - 3 * MAX_EXPONENT));
const MOTION_ORDERS = ["velocity", "acceleration", "jerk"] as const;

type Values = Map<AttributeName, Float32Array<ArrayBuffer>>;

/** Decodes a chunk. Every size is checked before anything is allocated. Rejects with ChunkError. */
export async function decodeChunk(bytes: Uint8Array): Promise<DecodedChunk> {
  await zstdReady();
  const { kind, count, timeRange, box, streams } = unpack(bytes);
  const known = ATTRIBUTES.filter((attribute) => kind === "dynamic" || !attribute.dynamicOnly);
  const values: Values = new Map();
  for (const stream of streams) {
    const attribute = known.find(({ id }) => id === stream.attribute);
    if (attribute) values.set(attribute.name, decodeStream(stream, attribute, count));
  }
  const common = {
    count,
    timeRange,
    box,
    logScales: required(values, "log_scale"),
    opacities: required(values, "opacity").map((opacity) => Math.min(1, Math.max(0, opacity))),
    rgb: required(values, "rgb"),
  };
  const chunk: DecodedChunk =
    kind === "static"
      ? { kind, ...common, means: required(values, "position"), quats: required(values, "rotation") }
      : { kind, ...common, ...polynomials(values, count) };
  for (const [name, array] of Object.entries(chunk)) {
    if (!(array instanceof Float32Array)) continue;
    const bad = array.findIndex((number) => !Number.isFinite(number));
    if (bad >= 0)
      throw new ChunkError(64, `${name} of splat ${Math.floor((bad * count) / array.length)}`, array[bad], "finite");
  }
  return chunk;
}

function required(values: Values, name: AttributeName): Float32Array<ArrayBuffer> {
  const array = values.get(name);
  if (!array) throw new ChunkError(64, "attribute table", `without ${name}`, "every attribute that is not optional");
  return array;
}

/** Puts the polynomials of a dynamic chunk together, and undoes their scaling by powers of two. */
function polynomials(values: Values, count: number) {
  const exponents = required(values, "time_exponent");
  const bad = exponents.findIndex((e) => !(Number.isInteger(e) && Math.abs(e) <= MAX_EXPONENT));
  if (bad >= 0) throw new ChunkError(64, `time_exponent of splat ${bad}`, exponents[bad], `whole, to ${MAX_EXPONENT}`);
  const motion = new Float32Array(count * 12);
  const rotation = new Float32Array(count * 8);
  place(required(values, "position"), 3, motion, 12, 0);
  place(required(values, "rotation"), 4, rotation, 8, 0);
  for (const [i, name] of MOTION_ORDERS.entries()) {
    const coefficients = values.get(name);
    if (coefficients) place(coefficients, 3, motion, 12, 3 * (i + 1), exponents, i + 1);
  }
  const turning = values.get("turning");
  if (turning) place(turning, 4, rotation, 8, 4, exponents, 1);
  return {
    motion,
    rotation,
    timeCenters: required(values, "time_center"),
    timeLogPrecisions: required(values, "time_log_precision"),
  };
}

/** Copies rows of `width` to `offset` in rows of `stride`, times 2^(order * exponent). */
function place(
  from: Float32Array,
  width: number,
  to: Float32Array,
  stride: number,
  offset: number,
  exponents?: Float32Array,
  order = 0,
): void {
  for (let i = 0, row = offset; i * width < from.length; i++, row += stride) {
    const power = exponents ? POWERS[order * exponents[i] + 3 * MAX_EXPONENT] : 1;
    for (let c = 0; c < width; c++) to[row + c] = from[i * width + c] * power;
  }
}

/** Returns the values [N * C] of one attribute; C is 4 for rotations. */
function decodeStream(stream: Stream, attribute: Attribute, count: number): Float32Array<ArrayBuffer> {
  const record = `attribute ${attribute.id} (${attribute.name})`;
  const { bits, step } = stream.grid;
  const expect = (condition: boolean, byte: number, field: string, found: unknown, expected: unknown) => {
    if (!condition) throw new ChunkError(byte, `${record} ${field}`, found, expected);
  };
  const { at, quantiser, components, transform, rawBytes } = stream;
  expect(quantiser === attribute.quantiser, at + 1, "quantiser", quantiser, attribute.quantiser);
  expect(components === attribute.components, at + 3, "components", components, attribute.components);
  const most = quantiser === QUANTISER.morton ? 0 : attribute.name === "rgb" ? TRANSFORM.green : TRANSFORM.delta;
  expect(transform <= most, at + 2, "transform", transform, `at most ${most}`);
  expect(bits >= 1 && bits <= MAX_BITS, at + 4, "bits", bits, `1 to ${MAX_BITS}`);
  expect(step > 0, at + 24, "step", step, "above 0");
  const planes = planesOf(attribute, bits);
  expect(rawBytes === planes * count, at + 16, "raw length", rawBytes, `${planes} x ${count} splats`);
  const raw = decompress(stream.data, rawBytes);
  if (!raw) throw new ChunkError(stream.dataAt, `${record} data`, "damaged", `a zstd frame of ${rawBytes} bytes`);
  if (quantiser === QUANTISER.morton) {
    const points = gridPoints(raw, count, bits);
    if (!points) throw new ChunkError(stream.dataAt, `${record} codes`, "beyond the grid", `below 2^${3 * bits}`);
    return dequantise(points, 3, stream.grid);
  }
  const codes = fromPlanes(raw, count, components, bits);
  const large = codes.findIndex((code) => code >= 2 ** bits);
  expect(large < 0, stream.dataAt, `code of splat ${Math.floor(large / components)}`, codes[large], `below 2^${bits}`);
  undoTransform(codes, components, bits, transform);
  const numbers = dequantise(codes, components, stream.grid);
  if (quantiser !== QUANTISER.smallestThree) return numbers;
  const index = raw.subarray(raw.length - count);
  const wrong = index.findIndex((i) => i > 3);
  expect(wrong < 0, stream.dataAt, `index code of splat ${wrong}`, index[wrong], "0 to 3");
  return quatsFromSmallestThree(index, numbers);
}
