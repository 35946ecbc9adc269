/** Starts workers, also for a page of another origin than the script's, as one that takes the player from a CDN. */

import address from "./worker.ts?worker&url";

/** As browsers offer it; TypeScript's library does not know it yet. */
interface TrustedTypes {
  createPolicy(name: string, rules: { createScriptURL(url: string): string }): { createScriptURL(url: string): string };
}

const worker = new URL(address, import.meta.url);
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
