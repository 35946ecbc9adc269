import { basename } from "node:path";
import type { Plugin, Rollup } from "vite";

/** A page to write: the module that index.html imports for it, and what is changed of index.html. */
export interface PreloadedPage {
  readonly module: string;
  /** Modules that the page's scripts import when they run, where it always comes to that. */
  readonly later?: readonly string[];
  readonly change?: (html: string) => string;
}

/**
 * Write pages that name every script and style sheet that they need, and what these fetch, so that a browser asks for all of it
 * at once: by itself it would find each only when it runs the one before.
 *
 * @param pages by the name of the file to write, e.g. `view.html`
 */
export function preloadedPages(pages: Readonly<Record<string, PreloadedPage>>): Plugin {
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
        for (const [page, { module, later = [], change }] of Object.entries(pages)) {
          const chunks = [module, ...later].map((name) => {
            const chunk = Object.values(bundle).find((c) => c.type === "chunk" && c.facadeModuleId?.endsWith(name));
            return chunk?.type === "chunk" ? chunk : this.error(`${page}: no script is imported for ${name}`);
          });
          const named = html.replace("  </head>", `${links(chunks, bundle, html, base)}  </head>`);
          const source = change ? change(named) : named;
          if (page === index.fileName) index.source = source;
          else this.emitFile({ type: "asset", fileName: page, source });
        }
      },
    },
  };
}

/**
 * Links to the style sheets and scripts of a page, given the first of these, the workers that it starts and what it fetches for them, but for those that the
 * page names already. Workers are said to be modules of the page: Chromium knows no other kind, and the worker finds them in the cache.
 */
function links(chunks: readonly Rollup.OutputChunk[], bundle: Rollup.OutputBundle, html: string, base: string): string {
  const scripts = new Set(chunks.map((chunk) => chunk.fileName));
  for (const name of scripts) {
    const imported = bundle[name];
    if (imported?.type === "chunk") for (const next of imported.imports) scripts.add(next); // the loop goes on to these
  }
  const styles = new Set<string>();
  // What others are built on comes first, as where it is imported.
  for (const name of [...scripts].reverse()) {
    const imported = bundle[name];
    if (imported?.type === "chunk") for (const style of imported.viteMetadata?.importedCss ?? []) styles.add(style);
  }
  // A script names what lies beside it without their folder.
  const code = [...scripts].map((name) => bundle[name]).flatMap((one) => (one?.type === "chunk" ? [one.code] : []));
  const named = (name: string): boolean => code.some((one) => one.includes(basename(name)));
  const assets = Object.keys(bundle).filter((name) => bundle[name].type === "asset" && named(name));
  const workers = assets.filter((name) => name.endsWith(".js"));
  const fetched = assets.filter((name) => name.endsWith(".wasm"));
  const link = (how: string) => (name: string) => `    <link ${how} crossorigin href="${base}${name}" />\n`;
  const unnamed = (name: string): boolean => !html.includes(base + name);
  return [
    ...[...styles].filter(unnamed).map(link('rel="stylesheet"')),
    ...[...scripts, ...workers].filter(unnamed).map(link('rel="modulepreload"')),
    ...fetched.map(link('rel="preload" as="fetch"')),
  ].join("");
}
