/** How large the player is that `npm run build` has written for static web servers: `npm run size`. */

import { readdirSync, readFileSync } from "node:fs";
import { brotliCompressSync, constants, gzipSync } from "node:zlib";

const FOLDER = "../server/viewer/player";

const rows = readdirSync(FOLDER)
  .filter((name) => /\.(js|wasm)$/.test(name))
  .map((name) => {
    const bytes = readFileSync(`${FOLDER}/${name}`);
    const brotli = brotliCompressSync(bytes, { params: { [constants.BROTLI_PARAM_SIZE_HINT]: bytes.length } });
    return { name, sizes: [bytes.length, gzipSync(bytes, { level: 9 }).length, brotli.length] };
  });
const all = { name: "all", sizes: [0, 1, 2].map((i) => rows.reduce((sum, row) => sum + row.sizes[i], 0)) };
const line = (name: string, cells: readonly unknown[]) =>
  `${name.padEnd(16)}${cells.map((cell) => String(cell).padStart(10)).join("")}\n`;
process.stdout.write(line("bytes", ["plain", "gzip", "brotli"]));
for (const { name, sizes } of [...rows, all]) process.stdout.write(line(name, sizes));
