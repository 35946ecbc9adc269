import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import type { Plugin } from "vite";

const MODULE = "virtual:zstd-address";
const RESOLVED = `\0${MODULE}`;

/** The decompressor's WebAssembly, which the package zstddec carries as text inside its script. */
export function zstdWasm(): Uint8Array<ArrayBuffer> {
  return zstd().source;
}

function zstd(): { source: Uint8Array<ArrayBuffer>; licence: string } {
  const path = createRequire(import.meta.url).resolve("zstddec");
  const script = readFileSync(path, "utf-8");
  const [, base64] = /const wasm = "([A-Za-z0-9+/=]+)"/.exec(script) ?? [];
  const [, terms] = /\/\*\*\n(\* BSD License\n[\s\S]*?)\*\//.exec(script) ?? [];
  if (!base64 || !terms) throw new Error("zstddec has changed: its script holds no WebAssembly, or no licence of zstd");
  const packaged = readFileSync(join(dirname(path), "../LICENSE"), "utf-8");
  const licence = `zstd.wasm is zstd as compiled for the package zstddec.\n\n${terms.replace(/^\* ?/gm, "")}\n${packaged}`;
  return { source: Uint8Array.from(Buffer.from(base64, "base64")), licence };
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
      const { source, licence } = zstd();
      if (serving) return `export default "data:application/wasm;base64,${Buffer.from(source).toString("base64")}"`;
      const file = this.emitFile({ type: "asset", name: "zstd.wasm", source });
      this.emitFile({ type: "asset", name: "zstd.LICENSE.txt", source: licence });
      return `export default import.meta.ROLLUP_FILE_URL_${file}`;
    },
  };
}
