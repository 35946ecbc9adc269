/** Decoding rates in Node: `npm run bench -- SCENE/chunks`, a folder of chunks. */

import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { zstdWasm } from "../plugins/zstd_wasm.ts";
import { provideZstd } from "../src/codec/zstd";
import { decodingRates } from "./rates";

const REPEATS = 200;

const folder = process.argv[2];
if (!folder) throw new Error("usage: npm run bench -- FOLDER_OF_CHUNKS");
const chunks = readdirSync(folder).map((file) => new Uint8Array(readFileSync(join(folder, file))));
await provideZstd(await WebAssembly.compile(zstdWasm()));
process.stdout.write(await decodingRates(chunks, REPEATS));
