/** The decompressor of chunks, fetched and compiled once for all workers of the page, while the first of them starts. */

import address from "virtual:zstd-address";

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
      const response = await fetch(new URL(address, import.meta.url));
      if (!response.ok) throw new Error(`the server answered ${response.status}`);
      return await WebAssembly.compile(await response.arrayBuffer()); // servers may not know the media type
    } catch (error) {
      if (tries === TRIES) throw error;
      await new Promise((resolve) => setTimeout(resolve, PAUSE));
    }
  }
}
