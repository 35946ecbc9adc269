/**
 * The steps from stored numbers to final values; each result is rounded to binary32, intermediate values are binary64.
 */

/** Target of an attribute's numbers: row i begins at `first` + i `stride`. */
export interface Layout {
  readonly values: Float32Array;
  readonly first: number;
  readonly stride: number;
}

/** Write rows of `components` numbers, 3 or 4, to the rows of their splats, times the splat's factor. */
export function scatter(
  numbers: Float32Array,
  components: number,
  members: Uint32Array,
  factors: Float64Array,
  { values, first, stride }: Layout,
): void {
  for (let row = 0, from = 0; row < members.length; row++, from += components) {
    const splat = members[row];
    const factor = factors[splat];
    const at = first + splat * stride;
    values[at] = numbers[from] * factor;
    values[at + 1] = numbers[from + 1] * factor;
    values[at + 2] = numbers[from + 2] * factor;
    if (components > 3) values[at + 3] = numbers[from + 3] * factor;
  }
}

/** Replace every x by x x (3 - 2 x), x limited to [0, 1]: stored numbers to opacities. */
export function ease(values: Float32Array): void {
  for (let i = 0; i < values.length; i++) {
    const x = Math.min(1, Math.max(0, values[i]));
    values[i] = x * x * (3 - 2 * x);
  }
}

/** Write w = sqrt(max(0, 1 - (x x + y y + z z))) before the vector parts x, y, z, which are `stride` apart. */
export function completeQuats(quats: Float32Array, stride: number): void {
  for (let at = 0; at < quats.length; at += stride) {
    const x = quats[at + 1];
    const y = quats[at + 2];
    const z = quats[at + 3];
    quats[at] = Math.sqrt(Math.max(0, 1 - (x * x + y * y + z * z)));
  }
}
