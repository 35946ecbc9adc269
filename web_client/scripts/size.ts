/**
 * How large the player is that `npm run build` has written for static web servers: `npm run size`. In parentheses what is
 * loaded only when it is asked for, such as for a headset.
 */

import { readdirSync, readFileSync } from "node:fs";
import { brotliCompressSync, constants, gzipSync } from "node:zlib";

const FOLDER = "../server/viewer/player";

const names = readdirSync(FOLDER).filter((name) => /\.(js|wasm)$/.test(name));
const scripts = names.filter((name) => name.endsWith(".js")).map((name) => readFileSync(`${FOLDER}/${name}`, "utf-8"));
/** What a script imports when it comes to that. */
const asked = scripts.flatMap((text) => Array.from(text.matchAll(/import\(\W\.\/([\w.]+)/g), ([, name]) => name));

const measured = (name: string) => {
  const bytes = readFileSync(`${FOLDER}/${name}`);
  const brotli = brotliCompressSync(bytes, { params: { [constants.BROTLI_PARAM_SIZE_HINT]: bytes.length } });
  return { name, sizes: [bytes.length, gzipSync(bytes, { level: 9 }).length, brotli.length] };
};
const rows = names.filter((name) => !asked.includes(name)).map(measured);
const all = { name: "all", sizes: [0, 1, 2].map((i) => rows.reduce((sum, row) => sum + row.sizes[i], 0)) };
const later = asked.map(measured).map((row) => ({ ...row, name: `(${row.name})` }));
const line = (name: string, cells: readonly unknown[]) =>
  `${name.padEnd(22)}${cells.map((cell) => String(cell).padStart(10)).join("")}\n`;
process.stdout.write(line("bytes", ["plain", "gzip", "brotli"]));
for (const { name, sizes } of [...rows, all, ...later]) process.stdout.write(line(name, sizes));
