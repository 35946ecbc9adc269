import type { Plugin, Rollup } from "vite";

/**
 * Write pages that name every script that they need, and what these fetch, so that a browser asks for all of it at once: by
 * itself it would find each only when it runs the one before.
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
 * Links to the scripts that a page runs, the workers that it starts and what it fetches for them, but for the scripts that the
 * page names already. Workers are said to be modules of the page: Chromium knows no other kind, and the worker finds them in the cache.
 */
function links(chunk: Rollup.OutputChunk, bundle: Rollup.OutputBundle, html: string, base: string): string {
  const scripts = new Set([chunk.fileName]);
  for (const name of scripts) {
    const imported = bundle[name];
    if (imported?.type === "chunk") for (const next of imported.imports) scripts.add(next); // the loop goes on to these
  }
  const assets = Object.keys(bundle).filter((name) => bundle[name].type === "asset" && chunk.code.includes(name));
  const workers = assets.filter((name) => name.endsWith(".js"));
  const fetched = assets.filter((name) => name.endsWith(".wasm"));
  const link = (how: string) => (name: string) => `    <link ${how} crossorigin href="${base}${name}" />\n`;
  return [
    ...[...scripts, ...workers].filter((name) => !html.includes(base + name)).map(link('rel="modulepreload"')),
    ...fetched.map(link('rel="preload" as="fetch"')),
  ].join("");
}
