import { readFileSync } from "node:fs";
import { join } from "node:path";
import type { Plugin } from "vite";

const MODULE = "virtual:zstd-address";
const RESOLVED = `\0${MODULE}`;
const FOLDER = "zstd"; // beside package.json, from where npm runs everything

/** The decompressor's WebAssembly, which zstd/build.py compiles. */
export function zstdWasm(): Uint8Array<ArrayBuffer> {
  return new Uint8Array(readFileSync(join(FOLDER, "zstd.wasm")));
}

/**
 * Let modules import the address of the decompressor, `import url from "virtual:zstd-address"`, and write it as a file of its
 * own, with its licence: as text it would be a third larger, and would compress worse.
 */
export function zstdWasmFile(): Plugin {
  let serving = false;
  return {
    name: "zstd-wasm-file",
    configResolved({ command }) {
      serving = command === "serve";
    },
    resolveId: (id) => (id === MODULE ? RESOLVED : null),
    load(id) {
      if (id !== RESOLVED) return null;
      const source = zstdWasm();
      if (serving) return `export default "data:application/wasm;base64,${Buffer.from(source).toString("base64")}"`;
      const file = this.emitFile({ type: "asset", name: "zstd.wasm", source });
      const licence = readFileSync(join(FOLDER, "LICENSE"), "utf-8");
      this.emitFile({
        type: "asset",
        name: "zstd.LICENSE.txt",
        source: `zstd.wasm is the decoder of zstd.\n\n${licence}`,
      });
      return `export default import.meta.ROLLUP_FILE_URL_${file}`;
    },
  };
}
