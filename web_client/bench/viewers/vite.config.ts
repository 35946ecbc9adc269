import { fileURLToPath } from "node:url";
import { defineConfig } from "vite";
import { leanShaders } from "../../plugins/lean_shaders.ts";
import { zstdWasmFile } from "../../plugins/zstd_wasm.ts";

// Run by `python -m benchmarks.viewers` in web_client/, with this folder as the root.
export default defineConfig({
  root: fileURLToPath(new URL(".", import.meta.url)),
  base: "./",
  plugins: [zstdWasmFile(), leanShaders()],
  worker: { format: "es" },
  build: { outDir: "node_modules/.bench", emptyOutDir: true, target: "es2022", chunkSizeWarningLimit: 1e5 },
});
