import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import type { Plugin } from "vite";

const MODULE = "virtual:zstd-address";
const RESOLVED = `\0${MODULE}`;

/** The decompressor's WebAssembly, which the package zstddec carries as text inside its script. */
export function zstdWasm(): Uint8Array<ArrayBuffer> {
  const script = readFileSync(createRequire(import.meta.url).resolve("zstddec"), "utf-8");
  const [, base64] = /const wasm = "([A-Za-z0-9+/=]+)"/.exec(script) ?? [];
  if (!base64) throw new Error("zstddec has changed: its script holds no WebAssembly");
  return Uint8Array.from(Buffer.from(base64, "base64"));
}

/**
 * Let modules import the address of the decompressor, `import url from "virtual:zstd-address"`, and write it as a file of its
 * own: as text it would be a third larger, and would compress worse.
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
      return `export default import.meta.ROLLUP_FILE_URL_${file}`;
    },
  };
}
