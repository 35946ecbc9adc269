/**
 * How large the player is that `npm run build` has written for static web servers: `npm run size`. Above the line what every
 * page with a scene in a folder loads; below it what is loaded when it comes to that, such as a headset's session.
 */

import { readdirSync, readFileSync } from "node:fs";
import { brotliCompressSync, constants, gzipSync } from "node:zlib";

const FOLDER = "../server/viewer/player";
const ENTRY = "hgs-player.js";

const names = readdirSync(FOLDER).filter((name) => /\.(js|wasm)$/.test(name));

/** What a file names of the others and needs at once: all but what a script imports when it comes to that. */
function needed(name: string): string[] {
  if (!name.endsWith(".js")) return [];
  const text = readFileSync(`${FOLDER}/${name}`, "utf-8").replaceAll(/import\([^)]*\)/g, "");
  return names.filter((other) => text.includes(other));
}

const all = new Set([ENTRY]);
for (const name of all) for (const next of needed(name)) all.add(next); // the loop goes on to these

const sizes = (name: string) => {
  const bytes = readFileSync(`${FOLDER}/${name}`);
  const brotli = brotliCompressSync(bytes, { params: { [constants.BROTLI_PARAM_SIZE_HINT]: bytes.length } });
  return [bytes.length, gzipSync(bytes, { level: 9 }).length, brotli.length];
};
const line = (name: string, cells: readonly unknown[]) =>
  process.stdout.write(`${name.padEnd(22)}${cells.map((cell) => String(cell).padStart(10)).join("")}\n`);

line("bytes", ["plain", "gzip", "brotli"]);
const rows = [...all].map(sizes);
[...all].forEach((name, i) => void line(name, rows[i]));
line(
  "all",
  [0, 1, 2].map((i) => rows.reduce((sum, row) => sum + row[i], 0)),
);
line("\nwhen it is needed", []);
for (const name of names) if (!all.has(name)) line(name, sizes(name));
