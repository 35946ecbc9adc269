/** The worker that computes the SHA-256 of files. */

import { sha256 } from "@noble/hashes/sha2.js";
import { bytesToHex } from "@noble/hashes/utils.js";

const BLOCK = 4 << 20; // bytes per read
const WHOLE = 128 << 20; // bytes of the largest file read as a whole

/**
 * SHA-256 of a file. The browser's own is many times as fast, but takes no streams, and is missing on pages without
 * https.
 */
async function hashOf(file: File): Promise<string> {
  if (file.size <= WHOLE && globalThis.crypto.subtle !== undefined)
    return bytesToHex(new Uint8Array(await crypto.subtle.digest("SHA-256", await file.arrayBuffer())));
  const hash = sha256.create();
  for (let start = 0; start < file.size; start += BLOCK)
    hash.update(new Uint8Array(await file.slice(start, start + BLOCK).arrayBuffer()));
  return bytesToHex(hash.digest());
}

addEventListener("message", async ({ data }: MessageEvent<{ id: number; file: File }>) => {
  try {
    postMessage({ id: data.id, sha256: await hashOf(data.file) });
  } catch {
    postMessage({ id: data.id, sha256: null });
  }
});
