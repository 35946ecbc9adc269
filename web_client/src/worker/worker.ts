/** The worker: decodes chunks, packs them for the renderer and orders splats, so that the page never waits for either. */

import { decodeChunk } from "../codec/decode";
import { provideZstd } from "../codec/zstd";
import { toHex } from "../protocol/messages";
import type { FromWorker, ToWorker } from "./messages";
import { packDynamics, packFifth, packStatics } from "./pack";
import { placeChunks } from "./placement";
import { SplatOrderer } from "./splat_order";

// The page's library types describe `self` as a window; of the worker's scope only this much is used.
const scope = self as unknown as {
  postMessage(message: FromWorker, transfer?: Transferable[]): void;
  onmessage: ((event: MessageEvent<ToWorker>) => void) | null;
};

let orderer: SplatOrderer | null = null;

/** Check that the bytes are those that the id names, where the browser offers SHA-256 (secure pages only). */
async function verify(id: string, bytes: Uint8Array<ArrayBuffer>): Promise<void> {
  if (!globalThis.crypto?.subtle) return;
  const digest = toHex(new Uint8Array(await crypto.subtle.digest("SHA-256", bytes)));
  if (digest !== id) throw new Error(`chunk ${id.slice(0, 12)}: the bytes have hash ${digest.slice(0, 12)}`);
}

async function addChunk(id: string, bytes: Uint8Array<ArrayBuffer>): Promise<void> {
  try {
    await verify(id, bytes);
    const chunk = await decodeChunk(bytes);
    if (!orderer) return;
    orderer.add(id, chunk);
    const texels = chunk.kind === "static" ? packStatics(chunk) : packDynamics(chunk);
    const fifth = chunk.kind === "static" ? new Float32Array(0) : packFifth(chunk);
    const first = orderer.placement.first.get(id) ?? 0;
    scope.postMessage({ type: "decoded", id, kind: chunk.kind, first, texels, fifth }, [texels.buffer, fifth.buffer]);
  } catch (error) {
    scope.postMessage({ type: "failed", id, message: error instanceof Error ? error.message : String(error) });
  }
}

scope.onmessage = ({ data }) => {
  switch (data.type) {
    case "decompressor":
      void provideZstd(data.module);
      break;
    case "scene":
      orderer = new SplatOrderer(data.manifest, placeChunks(data.manifest));
      break;
    case "chunk":
      void addChunk(data.id, data.bytes);
      break;
    case "order": {
      if (!orderer) return;
      const { request, recycled } = data;
      const begun = performance.now();
      const order = orderer.order(request, recycled);
      scope.postMessage({ type: "ordered", ...order, sortTime: performance.now() - begun }, [order.ids.buffer]);
      break;
    }
  }
};
