/** From codes to numbers, each operation rounded to binary32 where docs/format.md says so, else in binary64. */

import type { Grid } from "./container";

/** Writes (code - zero) * step of one component to `values` from `offset`, `stride` apart. */
export function dequantise(
  codes: Uint8Array | Uint32Array,
  grid: Grid,
  component: number,
  values: Float32Array,
  offset: number,
  stride: number,
): void {
  const { step, bits } = grid;
  const zero = grid.zeros[component];
  if (bits <= 8) {
    const table = new Float32Array(256);
    for (let code = 0; code < 256; code++) table[code] = (code - zero) * step;
    for (let i = 0, at = offset; i < codes.length; i++, at += stride) values[at] = table[codes[i]];
  } else {
    for (let i = 0, at = offset; i < codes.length; i++, at += stride) values[at] = (codes[i] - zero) * step;
  }
}

/** Replaces every x by x x (3 - 2 x), x limited to [0, 1]: opacities, of what is stored for them. */
export function ease(values: Float32Array): void {
  for (let i = 0; i < values.length; i++) {
    const x = Math.min(1, Math.max(0, values[i]));
    values[i] = x * x * (3 - 2 * x);
  }
}

/** Writes w = sqrt(max(0, 1 - (x x + y y + z z))) before the vector parts x, y, z, which lie `stride` apart. */
export function completeQuats(quats: Float32Array, stride: number): void {
  for (let at = 0; at < quats.length; at += stride) {
    const x = quats[at + 1];
    const y = quats[at + 2];
    const z = quats[at + 3];
    quats[at] = Math.sqrt(Math.max(0, 1 - (x * x + y * y + z * z)));
  }
}
