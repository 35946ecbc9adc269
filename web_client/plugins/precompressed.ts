import { readdir, readFile, writeFile } from "node:fs/promises";
import { resolve } from "node:path";
import { brotliCompressSync, constants, gzipSync } from "node:zlib";
import type { Plugin } from "vite";

/** Write each file that the build makes again as `<name>.br` and `<name>.gz`, where that is smaller. */
export function precompressed(): Plugin {
  let folder = "";
  return {
    name: "precompressed",
    apply: (_, { command, isSsrBuild }) => command === "build" && !isSsrBuild,
    configResolved(config) {
      folder = resolve(config.root, config.build.outDir);
    },
    async closeBundle() {
      for (const entry of await readdir(folder, { recursive: true, withFileTypes: true })) {
        if (!entry.isFile()) continue;
        const path = resolve(entry.parentPath, entry.name);
        const bytes = await readFile(path);
        const hint = { [constants.BROTLI_PARAM_SIZE_HINT]: bytes.length };
        const coded = { br: brotliCompressSync(bytes, { params: hint }), gz: gzipSync(bytes, { level: 9 }) };
        for (const [suffix, smaller] of Object.entries(coded))
          if (smaller.length < bytes.length) await writeFile(`${path}.${suffix}`, smaller);
      }
    },
  };
}
