/** What the page and its worker say to each other. Big arrays are transferred, never copied. */

import type { Manifest } from "../codec/types";
import type { OrderRequest, SplatOrder } from "./splat_order";

export type ToWorker =
  /** Once; chunks wait for it. */
  | { type: "decompressor"; module: WebAssembly.Module }
  /** Before its chunks, and again with every later version. */
  | { type: "scene"; manifest: Manifest }
  /** A complete chunk, as it came from the server; `rows` are those of the texture that its splats take, if they move. */
  | { type: "chunk"; id: string; bytes: Uint8Array<ArrayBuffer>; rows: readonly number[] }
  /** Forget a chunk that moves. */
  | { type: "evict"; id: string }
  /** Pack everything once more, for a graphics context that has come back empty. */
  | { type: "repack" }
  /** Order the splats; `recycled` gives back the ids of an earlier answer. One at a time. */
  | { type: "order"; request: OrderRequest; recycled?: Uint32Array<ArrayBuffer> };

/** A chunk's splats, packed as the data textures hold them. */
export interface DecodedSplats {
  readonly id: string;
  readonly kind: "static" | "dynamic";
  /** The id of its first splat, if it is static. */
  readonly first: number;
  /** The rows that its splats take, one after the other, if they move. */
  readonly rows: readonly number[];
  readonly texels: Float32Array<ArrayBuffer>;
  /** Of dynamic splats whose motion goes on to the fifth order; empty if none does. */
  readonly fifth: Float32Array<ArrayBuffer>;
}

export interface OrderedSplats extends SplatOrder {
  /** Milliseconds. */
  readonly sortTime: number;
}

export type FromWorker =
  | ({ type: "decoded" } & DecodedSplats)
  /** A chunk as it was; and then, that all are packed. */
  | ({ type: "packed" } & DecodedSplats)
  | { type: "repacked" }
  | { type: "failed"; id: string; message: string }
  | ({ type: "ordered" } & OrderedSplats);
