/** The player's sentences for failures, without the protocol's terms. */

import type { SourceFailure } from "../source/scene_source";

export const DECODER_STOPPED = "The decoder of this page has stopped. Reloading the page may help.";
export const NOT_LOADED = "A part of the player could not be loaded. Reloading the page may help.";

/** The sentence for a failure of the source; loaded on demand. */
export async function describeFailure(failure: SourceFailure): Promise<string> {
  const words = await import("./source_failures").catch(() => null);
  return words && failure !== "not-loaded" ? words.SOURCE_FAILURES[failure] : NOT_LOADED;
}
