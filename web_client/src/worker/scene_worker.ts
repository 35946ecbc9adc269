/** The page's side of the worker: all messages in both directions pass here. */

import type { Manifest } from "../codec/types";
import type { DecodedSplats, FromWorker, OrderedSplats, ToWorker } from "./messages";
import type { OrderRequest } from "./splat_order";
import { decompressor, startWorker } from "./start_worker";

export interface SceneWorkerEvents {
  /** A chunk's splats, packed for the renderer. */
  decoded(splats: DecodedSplats): void;
  /** A chunk's splats, packed again. */
  packed(splats: DecodedSplats): void;
  repacked(): void;
  /** A chunk cannot be decoded; `message` is the reason. */
  damaged(id: string, message: string): void;
  ordered(order: OrderedSplats): void;
  /** The worker has died; `cause` is for debugging. */
  stopped(cause: string): void;
}

export class SceneWorker {
  readonly #worker = startWorker();

  constructor(readonly events: SceneWorkerEvents) {
    this.#worker.onmessage = ({ data }: MessageEvent<FromWorker>) => this.#receive(data);
    this.#worker.onerror = ({ message }) => events.stopped(message);
    decompressor().then(
      (module) => this.#post({ type: "decompressor", module }),
      (error) => events.stopped(`zstd.wasm: ${error instanceof Error ? error.message : error}`),
    );
  }

  /** Set the scene of the chunks; first, and again when it has grown. */
  begin(manifest: Manifest): void {
    this.#post({ type: "scene", manifest });
  }

  /**
   * Decode a complete chunk, which is transferred; answered by `decoded` or `damaged`. `rows` are the texture rows for
   * its splats if it is dynamic.
   */
  decode(id: string, bytes: Uint8Array<ArrayBuffer>, rows: readonly number[] = []): void {
    this.#post({ type: "chunk", id, bytes, rows }, [bytes.buffer]);
  }

  /** Forget a decoded chunk. */
  evict(id: string): void {
    this.#post({ type: "evict", id });
  }

  /** Pack all chunks again; answered by `packed` for every chunk, and then by `repacked`. */
  repack(): void {
    this.#post({ type: "repack" });
  }

  /** Order the splats, one order at a time; `recycled` returns the ids of an earlier one. Answered by `ordered`. */
  order({ depth, frustum, exact, budget, time, from, until }: OrderRequest, recycled?: Uint32Array<ArrayBuffer>): void {
    const request = { depth, frustum, exact, budget, time, from, until };
    if (recycled) this.#post({ type: "order", request, recycled }, [recycled.buffer]);
    else this.#post({ type: "order", request });
  }

  dispose(): void {
    this.#worker.terminate();
  }

  #post(message: ToWorker, transfer: Transferable[] = []): void {
    this.#worker.postMessage(message, transfer);
  }

  #receive(message: FromWorker): void {
    switch (message.type) {
      case "decoded":
        this.events.decoded(message);
        break;
      case "packed":
        this.events.packed(message);
        break;
      case "repacked":
        this.events.repacked();
        break;
      case "failed":
        this.events.damaged(message.id, message.message);
        break;
      case "ordered":
        this.events.ordered(message);
        break;
    }
  }
}
