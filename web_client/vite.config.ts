import { defineConfig } from "vitest/config";
import { alwaysDark } from "./plugins/always_dark.ts";
import { leanShaders } from "./plugins/lean_shaders.ts";
import { precompressed } from "./plugins/precompressed.ts";
import { preloadedPages } from "./plugins/preloaded_pages.ts";
import { zstdWasmFile } from "./plugins/zstd_wasm.ts";

// `npm run dev` serves the pages itself and forwards the API to a running `hgs serve`.
const server = process.env.HGS_SERVER ?? "http://127.0.0.1:8000";

export default defineConfig({
  base: "./", // the server tells each page where the scripts are from there: a proxy may put all of it below any path
  plugins: [
    zstdWasmFile(),
    leanShaders(),
    preloadedPages({
      "view.html": {
        module: "/src/console/view_page.ts",
        later: ["/src/source/served_source.ts", "/src/ui/player_controls.ts"],
        change: alwaysDark,
      },
      "job.html": { module: "/src/console/job_page.ts" },
      "new.html": { module: "/src/console/submit_page.ts" },
      "index.html": { module: "/src/console/list_page.ts" },
    }),
    precompressed(),
  ],
  build: {
    outDir: "../server/viewer",
    emptyOutDir: true,
    target: "es2022",
    sourcemap: false,
    rolldownOptions: {
      output: {
        // What the player and its parts share, each less than the headers of an answer, in one file.
        codeSplitting: {
          groups: [
            {
              name: "shared",
              test: /src\/(dom\/(format|icons|shadow_style)|ui\/(playing|steering)|camera\/vector|xr\/offer)\.ts/,
            },
          ],
        },
      },
    },
  },
  worker: { format: "es" },
  server: { proxy: { "/v1": { target: server, ws: true } } },
  test: { include: ["tests/**/*.test.ts"], environment: "node", setupFiles: "tests/decompressor.ts" },
});
