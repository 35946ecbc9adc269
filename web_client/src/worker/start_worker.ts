/** The start of the worker, and its decompressor, fetched and compiled once for all workers of the page. */

import decompressorAddress from "virtual:zstd-address";
import workerAddress from "./worker.ts?worker&url";

/** The interface in browsers; TypeScript's library lacks it. */
interface TrustedTypes {
  createPolicy(name: string, rules: { createScriptURL(url: string): string }): { createScriptURL(url: string): string };
}

let trusted: string | undefined; // address for all workers of the page

export function startWorker(): Worker {
  // Not against import.meta.url once more: bundlers put a file's address in its place, which browsers cannot load from.
  const worker = new URL(workerAddress, document.baseURI);
  trusted ??= trust(worker.origin === origin ? worker.href : bootstrap(worker.href));
  return new Worker(trusted, { type: "module" });
}

/**
 * The address of a script of the page's own origin, which imports the worker's: browsers start no others. A sandboxed
 * frame has no origin, and Chromium treats a blob there as foreign.
 */
function bootstrap(address: string): string {
  const script = `import ${JSON.stringify(address)};`;
  if (origin === "null") return `data:text/javascript,${encodeURIComponent(script)}`;
  return URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
}

/** A trusted form of the address: pages with `require-trusted-types-for 'script'` start no other workers. */
function trust(url: string): string {
  const { trustedTypes } = globalThis as { trustedTypes?: TrustedTypes };
  try {
    return trustedTypes?.createPolicy("hgs-player", { createScriptURL: () => url }).createScriptURL(url) ?? url;
  } catch {
    return url; // the policy is not allowed; the start of the worker shows whether it is required
  }
}

const TRIES = 3;
const PAUSE = 1000; // ms between them

let module: Promise<WebAssembly.Module> | undefined;

/**
 * Fetch and compile the decompressor.
 *
 * @throws Error if it cannot be fetched; the next call tries again.
 */
export function decompressor(): Promise<WebAssembly.Module> {
  module ??= compile().catch((error) => {
    module = undefined;
    throw error;
  });
  return module;
}

async function compile(): Promise<WebAssembly.Module> {
  for (let tries = 1; ; tries++) {
    try {
      const response = await fetch(decompressorAddress);
      if (!response.ok) throw new Error(`the server answered ${response.status}`);
      return await WebAssembly.compile(await response.arrayBuffer()); // works with any media type
    } catch (error) {
      if (tries === TRIES) throw error;
      await new Promise((resolve) => setTimeout(resolve, PAUSE));
    }
  }
}
