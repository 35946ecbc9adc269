/** Chunks of which only the first bytes are here; they outlive a connection. */

import { type ChunkFrame, ProtocolError } from "./messages";

export class PartialChunks {
  readonly #parts = new Map<string, { bytes: Uint8Array<ArrayBuffer>; filled: number }>();

  /**
   * Put a frame in its place. Returns the chunk if that makes it complete.
   *
   * @throws ProtocolError if the frame does not follow the one before.
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

  /** Keep the first `count` of them, and return their ids and how many bytes of each are here. */
  keep(count: number): [string, number][] {
    for (const id of [...this.#parts.keys()].slice(count)) this.#parts.delete(id);
    return Array.from(this.#parts, ([id, { filled }]) => [id, filled]);
  }
}
