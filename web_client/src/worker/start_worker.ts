/** Starts the worker, and fetches and compiles its decompressor once for all workers of the page. */

import decompressorAddress from "virtual:zstd-address";
import workerAddress from "./worker.ts?worker&url";

/** As browsers offer it; TypeScript's library does not know it yet. */
interface TrustedTypes {
  createPolicy(name: string, rules: { createScriptURL(url: string): string }): { createScriptURL(url: string): string };
}

const worker = new URL(workerAddress, import.meta.url);
let trusted: string | undefined; // what starts all workers of the page

export function startWorker(): Worker {
  trusted ??= trust(worker.origin === origin ? worker.href : bootstrap());
  return new Worker(trusted, { type: "module" });
}

/**
 * Browsers start workers of the page's own origin only; such a one may then import the script. A sandboxed frame has no origin,
 * and Chromium takes a blob there for another's.
 */
function bootstrap(): string {
  const script = `import ${JSON.stringify(worker.href)};`;
  if (origin === "null") return `data:text/javascript,${encodeURIComponent(script)}`;
  return URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
}

/** On a page with `require-trusted-types-for 'script'` only addresses that a policy has made start workers. */
function trust(url: string): string {
  const { trustedTypes } = globalThis as { trustedTypes?: TrustedTypes };
  try {
    return trustedTypes?.createPolicy("hgs-player", { createScriptURL: () => url }).createScriptURL(url) ?? url;
  } catch {
    return url; // the page allows no such policy; whether it needs one, starting the worker tells
  }
}

const TRIES = 3;
const PAUSE = 1000; // ms between them

let module: Promise<WebAssembly.Module> | undefined;

/** @throws Error if it cannot be had; another call tries again. */
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
      const response = await fetch(new URL(decompressorAddress, import.meta.url));
      if (!response.ok) throw new Error(`the server answered ${response.status}`);
      return await WebAssembly.compile(await response.arrayBuffer()); // servers may not know the media type
    } catch (error) {
      if (tries === TRIES) throw error;
      await new Promise((resolve) => setTimeout(resolve, PAUSE));
    }
  }
}
