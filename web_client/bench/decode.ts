/**
 * How many splats of each kind one thread decodes in a second: `npm run bench -- SCENE/chunks`, a folder of chunks. Every chunk counts with its fastest of many decodings, which other work on the machine disturbs least.
 */

import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { decodeChunk } from "../src/codec/chunk";

const REPEATS = 200;

const folder = process.argv[2];
if (!folder) throw new Error("usage: npm run bench -- FOLDER_OF_CHUNKS");
const totals = { static: { chunks: 0, splats: 0, ms: 0 }, dynamic: { chunks: 0, splats: 0, ms: 0 } };
for (const file of readdirSync(folder)) {
  const bytes = new Uint8Array(readFileSync(join(folder, file)));
  const { kind, count } = await decodeChunk(bytes);
  let fastest = Infinity;
  for (let i = 0; i < REPEATS; i++) {
    const began = performance.now();
    await decodeChunk(bytes);
    fastest = Math.min(fastest, performance.now() - began);
  }
  totals[kind].chunks++;
  totals[kind].splats += count;
  totals[kind].ms += fastest;
}
for (const [kind, { chunks, splats, ms }] of Object.entries(totals)) {
  if (chunks)
    process.stdout.write(
      `${kind}: ${chunks} chunks, ${splats} splats, ${(splats / ms / 1000).toFixed(2)} M splats/s\n`,
    );
}
