/** From the bytes of a stream to integer codes: byte planes and transforms. */

import { TRANSFORM } from "./attributes";

/** Joins byte planes (components, low byte first) into codes, one array per component. */
export function fromPlanes(planes: readonly Uint8Array[], bits: number): (Uint8Array | Uint32Array)[] {
  const each = Math.ceil(bits / 8);
  if (each === 1) return [...planes];
  const codes: Uint32Array[] = [];
  for (let c = 0; c < planes.length; c += each) {
    const [low, middle, high] = planes.slice(c, c + each);
    const joined = new Uint32Array(low.length);
    for (let i = 0; i < joined.length; i++) joined[i] = low[i] | (middle[i] << 8);
    if (each === 3) for (let i = 0; i < joined.length; i++) joined[i] |= high[i] << 16;
    codes.push(joined);
  }
  return codes;
}

/** Undoes a transform in place; codes are below 2^bits before and after. */
export function undoTransform(codes: readonly (Uint8Array | Uint32Array)[], bits: number, transform: number): void {
  const mask = 2 ** bits - 1;
  if (transform === TRANSFORM.delta) {
    for (const component of codes) {
      let last = 0;
      for (let i = 0; i < component.length; i++) component[i] = last = (last + unzigzag(component[i])) & mask;
    }
  } else if (transform === TRANSFORM.chain) {
    for (let c = 1; c < codes.length; c++) {
      const before = codes[c - 1];
      const component = codes[c];
      for (let i = 0; i < component.length; i++) component[i] = (before[i] + unzigzag(component[i])) & mask;
    }
  }
}

function unzigzag(code: number): number {
  return (code >>> 1) ^ -(code & 1);
}
