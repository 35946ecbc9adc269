/** From codes to numbers, each operation rounded to binary32 (or binary64 where docs/format.md says so). */

import type { Grid } from "./container";

const { fround } = Math;

/** Values [N * C] of codes: origin + code * step. */
export function dequantise(codes: Uint32Array, components: number, grid: Grid): Float32Array<ArrayBuffer> {
  const values = new Float32Array(codes.length);
  const { step, origin } = grid;
  for (let i = 0; i < codes.length; i++) values[i] = origin[i % components] + fround(codes[i] * step);
  return values;
}

/** Quaternions [N * 4] from the index of the largest component and the other three. */
export function quatsFromSmallestThree(index: Uint8Array, three: Float32Array): Float32Array<ArrayBuffer> {
  const quats = new Float32Array(index.length * 4);
  for (let i = 0; i < index.length; i++) {
    const a = three[3 * i];
    const b = three[3 * i + 1];
    const c = three[3 * i + 2];
    const largest = index[i];
    const at = 4 * i;
    quats[at + (largest > 0 ? 0 : 1)] = a;
    quats[at + (largest > 1 ? 1 : 2)] = b;
    quats[at + (largest > 2 ? 2 : 3)] = c;
    quats[at + largest] = Math.sqrt(Math.max(0, 1 - (a * a + b * b + c * c)));
  }
  return quats;
}
