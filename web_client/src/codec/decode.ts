/** The decoder of chunks: bytes to float arrays, bit for bit as docs/format.md states. */

import { ATTRIBUTES, type AttributeName, attributeOf, knownStreams, type Streams } from "./attributes";
import { TABLE, unpack } from "./chunk";
import { ChunkError } from "./errors";
import { Forms } from "./forms";
import { completeQuats, ease, type Layout, scatter } from "./quantise";
import { readStream } from "./streams";
import type { DecodedChunk } from "./types";
import { zstdReady } from "./zstd";

const MAX_EXPONENT = 20;
const ORDERS = ["velocity", "acceleration", "jerk", "snap", "crackle"] as const;

type Floats = Float32Array<ArrayBuffer>;

/** Rows of a sparse attribute; reused for every chunk. */
let scratch = new Float32Array(0);

/** Decode a chunk. Every size is checked before anything is allocated. Rejects with ChunkError. */
export async function decodeChunk(bytes: Uint8Array): Promise<DecodedChunk> {
  await zstdReady();
  // No await from here on: the arrays that modules reuse serve one chunk at a time.
  const container = unpack(bytes);
  const { kind, count, timeRange, box, bounds } = container;
  const streams = knownStreams(container);
  const forms = new Forms(container, streams.get("form"));
  checkPresence(streams, forms);
  const reader = new Reader(streams, forms, count);
  const still = kind === "static";
  const means = reader.read("position", still ? 3 : reader.motionStride);
  const logScales = reader.read("log_scale");
  const rotations = reader.read("rotation", still ? 4 : 8, 1);
  completeQuats(rotations, still ? 4 : 8);
  const opacities = reader.read("opacity");
  ease(opacities);
  const rgb = reader.read("rgb");
  const common = { count, timeRange, box, bounds, logScales, opacities, rgb };
  const chunk: DecodedChunk = still
    ? { kind, ...common, means, quats: rotations }
    : { kind, ...common, motion: means, rotation: rotations, ...readTimes(reader, means, rotations) };
  if (!surelyFinite(streams)) checkFinite(chunk);
  return chunk;
}

/** Check that attributes with rows have a stream, and no others. */
function checkPresence(streams: Streams, forms: Forms): void {
  for (const attribute of ATTRIBUTES) {
    const { name, id } = attribute;
    if (name === "form") continue;
    const stream = streams.get(name);
    const needed = forms.rowsOf(attribute) > 0;
    if (needed && !stream) throw new ChunkError(TABLE, "attribute table", `without ${name}`, `attribute ${id}`);
    if (stream && !needed)
      throw new ChunkError(stream.at, `attribute ${id} (${name})`, "there", "no row of it by the form");
  }
}

/** Whether the grids keep every value below 2^27, so that it stays finite after scaling by at most 2^100. */
function surelyFinite(streams: Streams): boolean {
  for (const { grid } of streams.values()) {
    const largest = 2 ** grid.bits + Math.max(...grid.zeros.map(Math.abs));
    if (largest * grid.step >= 2 ** 27) return false;
  }
  return true;
}

function checkFinite(chunk: DecodedChunk): void {
  for (const [name, array] of Object.entries(chunk)) {
    if (!(array instanceof Float32Array)) continue;
    const bad = firstNotFinite(array);
    if (bad >= 0) {
      const splat = Math.floor((bad * chunk.count) / array.length);
      throw new ChunkError(TABLE, `${snake(name)} of splat ${splat}`, array[bad], "finite");
    }
  }
}

const snake = (name: string): string => name.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`);

/** Index of the first number that is not finite, or -1. */
function firstNotFinite(array: Float32Array): number {
  let sum = 0;
  for (let i = 0; i < array.length; i++) sum += array[i] * 0; // NaN as soon as one number is not finite
  return sum === 0 ? -1 : array.findIndex((number) => !Number.isFinite(number));
}

/** Decoder of a chunk's streams into its arrays. */
class Reader {
  constructor(
    private readonly streams: Streams,
    private readonly forms: Forms,
    readonly count: number,
  ) {}

  /** Numbers of a splat's motion for the highest order in the chunk. */
  get motionStride(): number {
    return this.streams.has("crackle") ? 18 : 12;
  }

  /** A new array with `stride` numbers per splat: the attribute's from `offset` on, zeros elsewhere. */
  read(name: AttributeName, stride = attributeOf(name).components, offset = 0): Floats {
    const values = new Float32Array(this.count * stride);
    const stream = this.streams.get(name);
    if (stream) readStream(stream, attributeOf(name), this.count, { values, first: offset, stride });
    return values;
  }

  /** Write a sparse attribute, times `factors` at each splat, to the splats that have it. */
  readSparse(name: AttributeName, factors: Float64Array, layout: Layout): void {
    const stream = this.streams.get(name);
    if (!stream) return;
    const attribute = attributeOf(name);
    const { components } = attribute;
    const members = this.forms.membersOf(attribute);
    if (scratch.length < members.length * components) scratch = new Float32Array(members.length * components);
    readStream(stream, attribute, members.length, { values: scratch, first: 0, stride: components });
    scatter(scratch, components, members, factors, layout);
  }
}

/** Read lives and the higher coefficients of the polynomials, and undo their scaling by powers of two. */
function readTimes(reader: Reader, motion: Floats, rotation: Floats) {
  const { count } = reader;
  const timeCenters = reader.read("time_center");
  const timeLogPrecisions = reader.read("time_log_precision");
  const bad = firstNotFinite(timeLogPrecisions);
  if (bad >= 0)
    throw new ChunkError(TABLE, `time_log_precision of splat ${bad}`, timeLogPrecisions[bad], "a finite number");
  const scales = new Float64Array(count); // 2^e, about the reciprocal of a splat's life
  for (let i = 0; i < count; i++) {
    const exact = Math.floor((timeLogPrecisions[i] - 1.75) * 0.7213475204444817);
    scales[i] = 1 << Math.min(MAX_EXPONENT, Math.max(0, exact));
    timeCenters[i] /= scales[i];
  }
  const powers = scales.slice(); // scales to the power of the coefficient's order
  ORDERS.forEach((name, k) => {
    if (k > 0) for (let i = 0; i < count; i++) powers[i] *= scales[i];
    reader.readSparse(name, powers, { values: motion, first: 3 * (k + 1), stride: reader.motionStride });
  });
  reader.readSparse("turning", scales, { values: rotation, first: 4, stride: 8 });
  return { timeCenters, timeLogPrecisions };
}
