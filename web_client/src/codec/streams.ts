/** The decoder of streams: zstd frames, then byte planes, transform and grid in one pass per component. */

import { type Attribute, TRANSFORM } from "./attributes";
import type { Grid, Stream } from "./chunk";
import { ChunkError } from "./errors";
import { dequantisePoints } from "./morton";
import type { Layout } from "./quantise";
import { decompress } from "./zstd";

/** The bytes of a stream's codes: planes of `rows` bytes, `each` for every component, the lowest byte first. */
interface Codes {
  readonly raw: Uint8Array;
  readonly rows: number;
  readonly each: number;
}

/** Decode a stream of `rows` rows to its target. Throws ChunkError. */
export function readStream(stream: Stream, attribute: Attribute, rows: number, layout: Layout): void {
  const { grid, planes, transform } = stream;
  const { bits } = grid;
  const record = `attribute ${attribute.id} (${attribute.name})`;
  const frames = planes.map(({ data }) => data);
  const raw = decompress(frames, rows);
  if (typeof raw === "number")
    throw new ChunkError(planes[raw].at, `${record} plane ${raw}`, "damaged", `a zstd frame of ${rows} bytes`);
  if (attribute.morton) {
    if (!dequantisePoints(raw, planes.length, rows, grid, layout))
      throw new ChunkError(planes[0].at, `${record} codes`, "beyond the grid", `below 2^${3 * bits}`);
    return;
  }
  const codes = { raw, rows, each: Math.ceil(bits / 8) };
  let seen = 0;
  if (transform === TRANSFORM.chain) seen = dequantiseChain(codes, grid, layout);
  else
    for (let c = 0; c < attribute.components; c++)
      seen |= dequantise(codes, c, transform === TRANSFORM.delta, grid, layout);
  if (seen >= 2 ** bits) {
    const { component, row, code } = firstTooLarge(codes, bits);
    throw new ChunkError(planes[component * codes.each].at, `${record} code of row ${row}`, code, `below 2^${bits}`);
  }
}

// Each loop reads three bytes of every code; masks hide the bytes that a code lacks.
const maskOf = (byte: number, each: number): number => (byte < each ? 255 : 0);

const join = (low: number, middle: number, high: number): number => low | (middle << 8) | (high << 16);

const unzigzag = (code: number): number => (code >>> 1) ^ -(code & 1);

/**
 * Write (code - zero) * step of one component, or of running sums if `delta`; returns the union of all bits of the
 * codes.
 */
function dequantise({ raw, rows, each }: Codes, component: number, delta: boolean, grid: Grid, layout: Layout): number {
  const { bits, step } = grid;
  const { values, first, stride } = layout;
  const zero = grid.zeros[component];
  const mask = 2 ** bits - 1;
  const middleMask = maskOf(1, each);
  const highMask = maskOf(2, each);
  const low = component * each * rows;
  const middle = low + (middleMask && rows);
  const high = middle + (highMask && rows);
  let seen = 0;
  let at = first + component;
  if (delta) {
    let sum = 0;
    for (let i = 0; i < rows; i++, at += stride) {
      const code = join(raw[low + i], raw[middle + i] & middleMask, raw[high + i] & highMask);
      seen |= code;
      sum = (sum + unzigzag(code)) & mask;
      values[at] = (sum - zero) * step;
    }
  } else {
    for (let i = 0; i < rows; i++, at += stride) {
      const code = join(raw[low + i], raw[middle + i] & middleMask, raw[high + i] & highMask);
      seen |= code;
      values[at] = (code - zero) * step;
    }
  }
  return seen;
}

/** The same for the three components of a chain. */
function dequantiseChain({ raw, rows, each }: Codes, grid: Grid, { values, first, stride }: Layout): number {
  const { bits, step } = grid;
  const [zeroA, zeroB, zeroC] = grid.zeros;
  const mask = 2 ** bits - 1;
  const middleMask = maskOf(1, each);
  const highMask = maskOf(2, each);
  const middle = middleMask && rows; // offset between a low byte and the next one
  const high = middle + (highMask && rows);
  let seen = 0;
  for (let i = 0, at = first; i < rows; i++, at += stride) {
    const b = i + each * rows;
    const c = b + each * rows;
    let code = join(raw[i], raw[i + middle] & middleMask, raw[i + high] & highMask);
    const codeB = join(raw[b], raw[b + middle] & middleMask, raw[b + high] & highMask);
    const codeC = join(raw[c], raw[c + middle] & middleMask, raw[c + high] & highMask);
    seen |= code | codeB | codeC;
    values[at] = (code - zeroA) * step;
    code = (code + unzigzag(codeB)) & mask;
    values[at + 1] = (code - zeroB) * step;
    code = (code + unzigzag(codeC)) & mask;
    values[at + 2] = (code - zeroC) * step;
  }
  return seen;
}

/** The largest code of the first component with a code of 2^bits or more. */
function firstTooLarge({ raw, rows, each }: Codes, bits: number): { component: number; row: number; code: number } {
  for (let component = 0; ; component++) {
    const codeOf = (row: number) => {
      let code = 0;
      for (let p = 0; p < each; p++) code |= raw[(component * each + p) * rows + row] << (8 * p);
      return code;
    };
    let largest = 0;
    for (let row = 1; row < rows; row++) if (codeOf(row) > codeOf(largest)) largest = row;
    if (codeOf(largest) >= 2 ** bits) return { component, row: largest, code: codeOf(largest) };
  }
}
