/** Morton codes: three limbs of 24 bits, each interleaving 8 bits of x, y and z (x lowest). */

import type { Grid } from "./chunk";
import type { Layout } from "./quantise";

const LIMB = 2 ** 24 - 1;

// The coordinates of the 12 low bits of a code: x in bits 0 to 3, y in 8 to 11, z in 16 to 19.
const GATHER = Int32Array.from({ length: 4096 }, (_, code) => {
  let packed = 0;
  for (let bit = 0; bit < 12; bit++) packed |= ((code >> bit) & 1) << (8 * (bit % 3) + Math.floor(bit / 3));
  return packed;
});

/** Coordinates of a limb: x in the lowest byte, then y and z. */
const gather = (limb: number): number => GATHER[limb & 4095] | (GATHER[limb >> 12] << 4);

/**
 * Add up the differences in `planes` byte planes of `rows` rows each (low byte first) and write the resulting points of
 * the grid. Returns false if a code reaches 2^(3 bits).
 */
export function dequantisePoints(raw: Uint8Array, planes: number, rows: number, grid: Grid, layout: Layout): boolean {
  const { bits, step } = grid;
  const [zeroX, zeroY, zeroZ] = grid.zeros;
  const { values, first, stride } = layout;
  // The upper planes of a limb may be absent; they count as zeros.
  const none = planes % 3 === 0 ? raw : new Uint8Array(rows);
  const [p0, p1, p2, p3, p4, p5, p6, p7, p8] = Array.from({ length: 9 }, (_, p) =>
    p < planes ? raw.subarray(p * rows, (p + 1) * rows) : none,
  );
  const limbs = Math.ceil(planes / 3);
  let low = 0;
  let middle = 0;
  let high = 0;
  let beyond = 0; // carry of the highest limb: outside any grid
  for (let i = 0, at = first; i < rows; i++, at += stride) {
    low += p0[i] | (p1[i] << 8) | (p2[i] << 16);
    let carry = low >> 24;
    low &= LIMB;
    let point = gather(low);
    let x = point & 255;
    let y = (point >> 8) & 255;
    let z = point >> 16;
    if (limbs > 1) {
      middle += (p3[i] | (p4[i] << 8) | (p5[i] << 16)) + carry;
      carry = middle >> 24;
      middle &= LIMB;
      point = gather(middle);
      x |= (point & 255) << 8;
      y |= point & 0xff00;
      z |= (point >> 8) & 0xff00;
    }
    if (limbs > 2) {
      high += (p6[i] | (p7[i] << 8) | (p8[i] << 16)) + carry;
      carry = high >> 24;
      high &= LIMB;
      point = gather(high);
      x |= (point & 255) << 16;
      y |= (point & 0xff00) << 8;
      z |= point & 0xff0000;
    }
    beyond |= carry;
    values[at] = (x - zeroX) * step;
    values[at + 1] = (y - zeroY) * step;
    values[at + 2] = (z - zeroZ) * step;
  }
  // The codes ascend, so the last one shows whether any is too large.
  return (
    !beyond && [low, middle, high].every((sum, limb) => sum < 2 ** Math.min(24, Math.max(0, 3 * bits - 24 * limb)))
  );
}
