/** What a player says when it cannot go on: a line for people, without the words of the protocol. */

import type { SourceFailure } from "../source/scene_source";

export const DECODER_STOPPED = "The decoder of this page has stopped. Reloading the page may help.";
export const NOT_LOADED = "A part of the player could not be loaded. Reloading the page may help.";

/** The words for a failure of the source, which are loaded when there is one. */
export async function describeFailure(failure: SourceFailure): Promise<string> {
  const words = await import("./source_failures").catch(() => null);
  return words && failure !== "not-loaded" ? words.SOURCE_FAILURES[failure] : NOT_LOADED;
}
