/** What the page and its worker say to each other. Big arrays are transferred, never copied. */

import type { Manifest } from "../codec/types";
import type { DepthAxis } from "./splat_order";

export type ToWorker =
  /** First, once. */
  | { type: "scene"; manifest: Manifest }
  /** A complete chunk, as it came from the server. */
  | { type: "chunk"; id: string; bytes: Uint8Array<ArrayBuffer> }
  /** Order the splats; `recycled` gives back the ids of an earlier answer. One at a time. */
  | { type: "order"; axis: DepthAxis; time: number; recycled?: Uint32Array<ArrayBuffer> };

export type FromWorker =
  | {
      type: "decoded";
      id: string;
      kind: "static" | "dynamic";
      first: number;
      texels: Float32Array<ArrayBuffer>;
      /** Of dynamic splats whose motion goes on to the fifth order; empty if none does. */
      fifth: Float32Array<ArrayBuffer>;
    }
  | { type: "failed"; id: string; message: string }
  | {
      type: "ordered";
      normalisedTime: number;
      ids: Uint32Array<ArrayBuffer>;
      count: number;
      dynamic: number;
      /** Milliseconds. */
      sortTime: number;
    };
