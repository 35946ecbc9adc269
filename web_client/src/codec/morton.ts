/** Morton codes: three limbs of 24 bits, each interleaving 8 bits of x, y and z (x lowest). */

const LIMB = 2 ** 24;

/**
 * Adds up the differences in byte planes (low byte first) and returns the grid points [N * 3], or undefined if a code
 * reaches 2^(3 bits).
 */
export function gridPoints(raw: Uint8Array, count: number, bits: number): Uint32Array | undefined {
  const planes = Math.ceil((3 * bits) / 8);
  const points = new Uint32Array(count * 3);
  const limbs = [0, 0, 0];
  for (let i = 0; i < count; i++) {
    let carry = 0;
    for (let limb = 0; limb < 3; limb++) {
      let sum = limbs[limb] + carry;
      for (let p = 3 * limb; p < 3 * limb + 3 && p < planes; p++) sum += raw[p * count + i] << (8 * (p - 3 * limb));
      carry = sum >= LIMB ? 1 : 0;
      limbs[limb] = sum - carry * LIMB;
    }
    if (carry) return undefined;
    for (let axis = 0; axis < 3; axis++) {
      points[3 * i + axis] =
        everyThird(limbs[0] >> axis) | (everyThird(limbs[1] >> axis) << 8) | (everyThird(limbs[2] >> axis) << 16);
    }
  }
  // The codes ascend, so the last one shows whether any is too large.
  const top = 3 * bits;
  for (let limb = 0; limb < 3; limb++) {
    const allowed = Math.min(24, Math.max(0, top - 24 * limb));
    if (limbs[limb] >= 2 ** allowed) return undefined;
  }
  return points;
}

/** Gathers bits 0, 3, ..., 21. */
function everyThird(code: number): number {
  let x = code & 0x249249;
  x = (x | (x >> 2)) & 0x0c30c3;
  x = (x | (x >> 4)) & 0x00f00f;
  return (x | (x >> 8)) & 0xff;
}
