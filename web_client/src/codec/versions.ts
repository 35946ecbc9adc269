/** Versions of the format that are read; the second has motions of the fifth order. */
export const VERSIONS: readonly number[] = [2, 3];
