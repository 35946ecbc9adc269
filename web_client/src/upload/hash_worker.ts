/** Computes the SHA-256 of files, apart from the page; browsers' own can do neither streams nor pages without https. */

import { sha256 } from "@noble/hashes/sha2.js";
import { bytesToHex } from "@noble/hashes/utils.js";

const BLOCK = 4 << 20; // bytes that are read at once

addEventListener("message", async ({ data }: MessageEvent<{ id: number; file: File }>) => {
  try {
    const hash = sha256.create();
    for (let start = 0; start < data.file.size; start += BLOCK)
      hash.update(new Uint8Array(await data.file.slice(start, start + BLOCK).arrayBuffer()));
    postMessage({ id: data.id, sha256: bytesToHex(hash.digest()) });
  } catch {
    postMessage({ id: data.id, sha256: null });
  }
});
