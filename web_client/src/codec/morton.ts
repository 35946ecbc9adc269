/** Morton codes: three limbs of 24 bits, each interleaving 8 bits of x, y and z (x lowest). */

const LIMB = 2 ** 24;

// The coordinates of the 12 low bits of a code: x in bits 0 to 3, y in 8 to 11, z in 16 to 19.
const GATHER = Uint32Array.from({ length: 4096 }, (_, code) => {
  let packed = 0;
  for (let bit = 0; bit < 12; bit++) packed |= ((code >> bit) & 1) << (8 * (bit % 3) + Math.floor(bit / 3));
  return packed;
});

/**
 * Adds up the differences in byte planes (low byte first) and returns the coordinates, one array per axis, or undefined
 * if a code reaches 2^(3 bits).
 */
export function gridPoints(planes: readonly Uint8Array[], bits: number): Uint32Array[] | undefined {
  const count = planes[0].length;
  const used = Math.ceil(planes.length / 3);
  const points = [new Uint32Array(count), new Uint32Array(count), new Uint32Array(count)];
  const [xs, ys, zs] = points;
  // The upper planes of a limb may be absent: an empty one reads as zeros.
  const none = new Uint8Array(count);
  const sums = [0, 0, 0];
  const carries = new Uint8Array(count);
  for (let limb = 0; limb < used; limb++) {
    const [low, middle, high] = [0, 1, 2].map((p) => planes[3 * limb + p] ?? none);
    const shift = 8 * limb;
    let sum = 0;
    for (let i = 0; i < count; i++) {
      sum += (low[i] | (middle[i] << 8) | (high[i] << 16)) + carries[i];
      carries[i] = sum >= LIMB ? 1 : 0;
      if (carries[i]) sum -= LIMB;
      const a = GATHER[sum & 4095];
      const b = GATHER[sum >> 12];
      const packed = a | (b << 4);
      xs[i] |= (packed & 255) << shift;
      ys[i] |= ((packed >> 8) & 255) << shift;
      zs[i] |= ((packed >> 16) & 255) << shift;
    }
    sums[limb] = sum;
    // A carry out of the last limb is beyond any grid.
    if (limb === used - 1 && carries.indexOf(1) >= 0) return undefined;
  }
  // The codes ascend, so the last one shows whether any is too large.
  for (let limb = 0; limb < 3; limb++) {
    const allowed = Math.min(24, Math.max(0, 3 * bits - 24 * limb));
    if (sums[limb] >= 2 ** allowed) return undefined;
  }
  return points;
}
