/** Gives tests the decompressor, which pages fetch. */

import { zstdWasm } from "../plugins/zstd_wasm.ts";
import { provideZstd } from "../src/codec/zstd";

await provideZstd(await WebAssembly.compile(zstdWasm()));
