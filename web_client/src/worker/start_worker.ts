/** Starts workers, also for a page of another origin than the script's, as one that takes the player from a CDN. */

import address from "./worker.ts?worker&url";

let bootstrap: string | undefined; // for all players of the page

export function startWorker(): Worker {
  const url = new URL(address, import.meta.url);
  if (url.origin === location.origin) return new Worker(url, { type: "module" });
  // Browsers start workers of the page's own origin only; such a one may then import the script.
  bootstrap ??= URL.createObjectURL(new Blob([`import ${JSON.stringify(url.href)};`], { type: "text/javascript" }));
  return new Worker(bootstrap, { type: "module" });
}
