/** The worker: decodes chunks, packs them for the renderer and orders splats, so that the page never blocks. */

import { decodeChunk } from "../codec/decode";
import { toHex } from "../codec/hex";
import type { DecodedChunk } from "../codec/types";
import { provideZstd } from "../codec/zstd";
import type { FromWorker, ToWorker } from "./messages";
import { WorkerScene } from "./worker_scene";

// The page's library types declare `self` as a window; this is the used part of the worker's scope.
const scope = self as unknown as {
  postMessage(message: FromWorker, transfer?: Transferable[]): void;
  onmessage: ((event: MessageEvent<ToWorker>) => void) | null;
};

/** Check that the bytes have the hash of the id, if the browser offers SHA-256 (secure pages only). */
async function verify(id: string, bytes: Uint8Array<ArrayBuffer>): Promise<void> {
  if (!globalThis.crypto?.subtle) return;
  const digest = toHex(new Uint8Array(await crypto.subtle.digest("SHA-256", bytes)));
  if (digest !== id) throw new Error(`chunk ${id.slice(0, 12)}: the bytes have hash ${digest.slice(0, 12)}`);
}

async function decode(id: string, bytes: Uint8Array<ArrayBuffer>): Promise<DecodedChunk> {
  await verify(id, bytes);
  return decodeChunk(bytes);
}

const scene = new WorkerScene(decode, (message, transfer) => scope.postMessage(message, transfer));
scope.onmessage = ({ data }) => {
  if (data.type === "decompressor") void provideZstd(data.module);
  else scene.receive(data);
};
