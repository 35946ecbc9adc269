/** A chunk that is truncated, damaged or not of this format: names the byte, the record, the value and what was expected. */
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

/** A manifest with a field that is missing or wrong, or a file that is not what it says: names it and what was expected. */
export class ManifestError extends Error {
  override readonly name = "ManifestError";

  constructor(
    readonly path: string,
    problem: string,
  ) {
    super(`${path}: ${problem}`);
  }
}
