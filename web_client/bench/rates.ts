/** How many splats of each kind a thread decodes in a second. */

import { decodeChunk } from "../src/codec/decode";

/** Every chunk counts with its fastest of `repeats` decodings, which other work on the machine disturbs least. */
export async function decodingRates(chunks: readonly Uint8Array[], repeats: number): Promise<string> {
  const totals = { static: { chunks: 0, splats: 0, ms: 0 }, dynamic: { chunks: 0, splats: 0, ms: 0 } };
  for (const bytes of chunks) {
    const { kind, count } = await decodeChunk(bytes);
    let fastest = Infinity;
    for (let i = 0; i < repeats; i++) {
      const began = performance.now();
      await decodeChunk(bytes);
      fastest = Math.min(fastest, performance.now() - began);
    }
    totals[kind].chunks++;
    totals[kind].splats += count;
    totals[kind].ms += fastest;
  }
  const lines = Object.entries(totals).map(([kind, { chunks, splats, ms }]) =>
    chunks ? `${kind}: ${chunks} chunks, ${splats} splats, ${(splats / ms / 1000).toFixed(2)} M splats/s\n` : "",
  );
  return lines.join("");
}
