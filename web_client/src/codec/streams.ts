/** From the bytes of a stream to integer codes: byte planes and transforms. */

import { TRANSFORM } from "./attributes";

/** Joins byte planes (components, low byte first, then splats) into codes [N * C], components of a splat together. */
export function fromPlanes(raw: Uint8Array, count: number, components: number, bits: number): Uint32Array {
  const codes = new Uint32Array(count * components);
  const planes = Math.ceil(bits / 8);
  for (let c = 0; c < components; c++) {
    for (let p = 0; p < planes; p++) {
      const from = (c * planes + p) * count;
      for (let i = 0; i < count; i++) codes[i * components + c] |= raw[from + i] << (8 * p);
    }
  }
  return codes;
}

/** Undoes a transform in place; `codes` are below 2^bits before and after. */
export function undoTransform(codes: Uint32Array, components: number, bits: number, transform: number): void {
  const mask = 2 ** bits - 1;
  if (transform === TRANSFORM.delta) {
    for (let i = 0; i < codes.length; i++) {
      const before = i < components ? 0 : codes[i - components];
      codes[i] = (before + unzigzag(codes[i])) & mask;
    }
  } else if (transform === TRANSFORM.green) {
    for (let i = 0; i < codes.length; i += 3) {
      const green = codes[i];
      codes[i] = (green + unzigzag(codes[i + 1])) & mask;
      codes[i + 1] = green;
      codes[i + 2] = (green + unzigzag(codes[i + 2])) & mask;
    }
  }
}

function unzigzag(code: number): number {
  return (code >>> 1) ^ -(code & 1);
}
