/** Incomplete chunks: their first bytes outlive a connection. */

import { type ChunkFrame, ProtocolError } from "./messages";

export class PartialChunks {
  readonly #parts = new Map<string, { bytes: Uint8Array<ArrayBuffer>; filled: number }>();

  /**
   * Add a frame. Returns the chunk if it is complete now.
   *
   * @throws ProtocolError if the frame is not the next one.
   */
  add({ id, offset, size, payload }: ChunkFrame): Uint8Array<ArrayBuffer> | null {
    const part = this.#parts.get(id) ?? { bytes: new Uint8Array(size), filled: 0 };
    if (offset !== part.filled || size !== part.bytes.length) {
      throw new ProtocolError(`chunk ${id.slice(0, 12)}: byte ${offset} of ${size} came after ${part.filled}`);
    }
    part.bytes.set(payload, offset);
    part.filled += payload.length;
    if (part.filled < size) {
      this.#parts.set(id, part);
      return null;
    }
    this.#parts.delete(id);
    return part.bytes;
  }

  drop(id: string): void {
    this.#parts.delete(id);
  }

  /** Keep the first `count` chunks, and return their ids and the numbers of their bytes. */
  keep(count: number): [string, number][] {
    for (const id of [...this.#parts.keys()].slice(count)) this.#parts.delete(id);
    return Array.from(this.#parts, ([id, { filled }]) => [id, filled]);
  }
}
