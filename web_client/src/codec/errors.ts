/**
 * Error for a chunk that is truncated, damaged or not of this format, with the byte, the record, the value found and
 * the one expected.
 */
export class ChunkError extends Error {
  override readonly name = "ChunkError";

  constructor(
    readonly byte: number,
    readonly record: string,
    readonly found: unknown,
    readonly expected: unknown,
  ) {
    super(`chunk: byte ${byte}: ${record}: is ${found}, expected ${expected}`);
  }
}

/**
 * Error for a manifest with a missing or wrong field, or for a file of another kind, with the field and the
 * expectation.
 */
export class ManifestError extends Error {
  override readonly name = "ManifestError";

  constructor(
    readonly path: string,
    problem: string,
  ) {
    super(`${path}: ${problem}`);
  }
}
