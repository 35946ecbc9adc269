/** The messages between the page and its worker. Big arrays are transferred, never copied. */

import type { Manifest } from "../codec/types";
import type { OrderRequest, SplatOrder } from "./splat_order";

export type ToWorker =
  /** Once; chunks wait for it. */
  | { type: "decompressor"; module: WebAssembly.Module }
  /** Before its chunks, and again with every later version. */
  | { type: "scene"; manifest: Manifest }
  /** A complete chunk, as received; `rows` are the texture rows for its splats if it is dynamic. */
  | { type: "chunk"; id: string; bytes: Uint8Array<ArrayBuffer>; rows: readonly number[] }
  /** Forget a dynamic chunk. */
  | { type: "evict"; id: string }
  /** Pack everything again, for a restored graphics context. */
  | { type: "repack" }
  /** Order the splats; `recycled` returns the ids of an earlier answer. One order at a time. */
  | { type: "order"; request: OrderRequest; recycled?: Uint32Array<ArrayBuffer> };

/** A chunk's splats, packed as the data textures hold them. */
export interface DecodedSplats {
  readonly id: string;
  readonly kind: "static" | "dynamic";
  /** The id of its first splat, for a static chunk. */
  readonly first: number;
  /** The rows for its splats, in sequence, for a dynamic chunk. */
  readonly rows: readonly number[];
  readonly texels: Float32Array<ArrayBuffer>;
  /** Coefficients of the fifth order, for dynamic splats with such motions; empty if none has. */
  readonly fifth: Float32Array<ArrayBuffer>;
}

export interface OrderedSplats extends SplatOrder {
  /** Milliseconds. */
  readonly sortTime: number;
}

export type FromWorker =
  | ({ type: "decoded" } & DecodedSplats)
  /** A chunk packed again; and then, the end of all chunks. */
  | ({ type: "packed" } & DecodedSplats)
  | { type: "repacked" }
  | { type: "failed"; id: string; message: string }
  | ({ type: "ordered" } & OrderedSplats);
