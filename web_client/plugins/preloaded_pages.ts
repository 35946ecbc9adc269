import type { Plugin, Rollup } from "vite";

/**
 * Write pages that name every script they need, so that a browser asks for all of them at once: by itself it would
 * find each only when it runs the one before.
 *
 * @param pages for each page to write, e.g. `view.html`, the module that index.html imports for it
 */
export function preloadedPages(pages: Readonly<Record<string, string>>): Plugin {
  let base = "/";
  return {
    name: "preloaded-pages",
    apply: (_, { command, isSsrBuild }) => command === "build" && !isSsrBuild,
    configResolved(config) {
      base = config.base;
    },
    generateBundle: {
      order: "post",
      handler(_, bundle) {
        const index = bundle["index.html"];
        if (index?.type !== "asset") return this.error("there is no index.html to begin with");
        const html = String(index.source);
        for (const [page, module] of Object.entries(pages)) {
          const chunk = Object.values(bundle).find((c) => c.type === "chunk" && c.facadeModuleId?.endsWith(module));
          if (chunk?.type !== "chunk") return this.error(`${page}: index.html imports no ${module}`);
          const source = html.replace("  </head>", `${links(chunk, bundle, html, base)}  </head>`);
          if (page === index.fileName) index.source = source;
          else this.emitFile({ type: "asset", fileName: page, source });
        }
      },
    },
  };
}

/**
 * Links to the scripts that a page runs and the workers that it starts, but for those that the page names already.
 * Workers are said to be modules of the page: Chromium knows no other kind, and the worker finds them in the cache.
 */
function links(chunk: Rollup.OutputChunk, bundle: Rollup.OutputBundle, html: string, base: string): string {
  const scripts = new Set([chunk.fileName]);
  for (const name of scripts) {
    const imported = bundle[name];
    if (imported?.type === "chunk") for (const next of imported.imports) scripts.add(next); // the loop goes on to these
  }
  const workers = Object.keys(bundle).filter(
    (name) => bundle[name].type === "asset" && name.endsWith(".js") && chunk.code.includes(name),
  );
  return [...scripts, ...workers]
    .map((name) => base + name)
    .filter((address) => !html.includes(address))
    .map((address) => `    <link rel="modulepreload" crossorigin href="${address}" />\n`)
    .join("");
}
