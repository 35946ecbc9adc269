/** The worker's part of a scene: compressed chunks, and the data of their splats for orders. */

import type { DecodedChunk } from "../codec/types";
import { placeStatics } from "../renderer/layout";
import type { FromWorker, ToWorker } from "./messages";
import { packDynamics, packFifth, packStatics } from "./pack";
import { type OrderRequest, SplatOrderer } from "./splat_order";

interface Chunk {
  readonly bytes: Uint8Array<ArrayBuffer>;
  readonly rows: readonly number[];
}

export class WorkerScene {
  #orderer: SplatOrderer | null = null;
  /** The compressed chunks of the textures' content, about a tenth of its size, to fill a restored context. */
  readonly #chunks = new Map<string, Chunk>();

  constructor(
    readonly decode: (id: string, bytes: Uint8Array<ArrayBuffer>) => Promise<DecodedChunk>,
    readonly post: (message: FromWorker, transfer: Transferable[]) => void,
  ) {}

  /** Handle a message of the page. */
  receive(message: Exclude<ToWorker, { type: "decompressor" }>): void {
    switch (message.type) {
      case "scene":
        if (this.#orderer) this.#orderer.grow(message.manifest);
        else this.#orderer = new SplatOrderer(message.manifest, placeStatics(message.manifest));
        break;
      case "chunk":
        void this.#add(message.id, { bytes: message.bytes, rows: message.rows });
        break;
      case "evict":
        this.#chunks.delete(message.id);
        this.#orderer?.evict(message.id);
        break;
      case "repack":
        void this.#repack();
        break;
      case "order":
        this.#order(message.request, message.recycled);
        break;
    }
  }

  async #add(id: string, chunk: Chunk): Promise<void> {
    try {
      const decoded = await this.decode(id, chunk.bytes);
      if (!this.#orderer) return;
      this.#orderer.add(id, decoded, chunk.rows);
      this.#chunks.set(id, chunk);
      this.#pack("decoded", id, decoded, chunk.rows);
    } catch (error) {
      this.post({ type: "failed", id, message: error instanceof Error ? error.message : String(error) }, []);
    }
  }

  async #repack(): Promise<void> {
    for (const [id, chunk] of [...this.#chunks]) {
      const decoded = await this.decode(id, chunk.bytes);
      // Otherwise it has been evicted, and its rows may be in use again.
      if (this.#chunks.get(id) === chunk) this.#pack("packed", id, decoded, chunk.rows);
    }
    this.post({ type: "repacked" }, []);
  }

  #pack(type: "decoded" | "packed", id: string, chunk: DecodedChunk, rows: readonly number[]): void {
    const still = chunk.kind === "static";
    const texels = still ? packStatics(chunk) : packDynamics(chunk);
    const fifth = still ? new Float32Array(0) : packFifth(chunk);
    const first = this.#orderer?.placement.first.get(id) ?? 0;
    this.post({ type, id, kind: chunk.kind, first, rows, texels, fifth }, [texels.buffer, fifth.buffer]);
  }

  #order(request: OrderRequest, recycled?: Uint32Array<ArrayBuffer>): void {
    if (!this.#orderer) return;
    const begun = performance.now();
    const order = this.#orderer.order(request, recycled);
    this.post({ type: "ordered", ...order, sortTime: performance.now() - begun }, [order.ids.buffer]);
  }
}
