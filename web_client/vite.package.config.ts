import { defineConfig } from "vite";
import { leanShaders } from "./plugins/lean_shaders.ts";
import { pageIcon } from "./plugins/page_icon.ts";
import { precompressed } from "./plugins/precompressed.ts";
import { terse } from "./plugins/terse.ts";
import { zstdWasmFile } from "./plugins/zstd_wasm.ts";

/**
 * The player without a page around it. `vite build -c vite.package.config.ts` makes the npm package in dist/, with an entry for
 * each of its exports; with `--mode site` what a static web server needs beside a scene: player/hgs-player.js, which registers
 * the element, and what it loads.
 */
export default defineConfig(({ mode }) => {
  const site = mode === "site";
  const entry: Record<string, string> = site
    ? { "hgs-player": "src/element/define.ts" }
    : {
        index: "src/index.ts",
        element: "src/element/define.ts",
        three: "src/three/hgs_scene.ts",
        "three-webgpu": "src/three/hgs_scene_webgpu.ts",
        playcanvas: "src/playcanvas/hgs_scene_entity.ts",
      };
  return {
    base: "./", // addresses relative to the script that has them
    publicDir: false,
    plugins: [zstdWasmFile(), leanShaders(), ...(site ? [pageIcon(), terse(), precompressed()] : [])],
    build: {
      outDir: site ? "../server/viewer/player" : "dist",
      emptyOutDir: true,
      target: "es2022",
      lib: { entry, formats: ["es"] },
      rolldownOptions: {
        external: [/^(three|playcanvas)(\/|$)/], // the host's own
        // What the element's script shares with parts that are loaded later stays in it: one round trip less.
        preserveEntrySignatures: site ? "allow-extension" : "strict",
        output: {
          chunkFileNames: "[name].js",
          assetFileNames: "[name][extname]",
          minify: true,
          // A part of another version than the script that loads it should fail, and not take one function for another.
          minifyInternalExports: !site,
        },
      },
    },
    worker: { format: "es", rolldownOptions: { output: { entryFileNames: "worker.js" } } },
  };
});
