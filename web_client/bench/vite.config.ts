/** Bundles the worker of the benchmark as the viewer's own worker is bundled. */

import { defineConfig } from "vite";

export default defineConfig({
  publicDir: false,
  build: {
    outDir: "node_modules/.bench",
    lib: { entry: "bench/worker.ts", formats: ["es"], fileName: () => "worker.js" },
  },
});
