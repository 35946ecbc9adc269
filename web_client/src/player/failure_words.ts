/** What a player says when it cannot go on: a line for people, without the words of the protocol. */

import type { SourceFailure } from "../source/scene_source";

const WORDS: Readonly<Record<SourceFailure, string>> = {
  "no-scene": "There is no such scene here. It may have been taken away.",
  "scene-changed": "This scene has been published anew. Load the page again to see it.",
  "not-understood": "This page and the server are of different versions. Loading the page again may help.",
  "not-loaded": "A part of the player could not be loaded. Loading the page again may help.",
  ended: "The server has ended the stream. Loading the page again may help.",
};

export const DECODER_STOPPED = "The decoder of this page has stopped. Loading the page again may help.";
export const SCENE_UNREADABLE = "This page cannot read the scene. Loading the page again may help.";

export function describeFailure(failure: SourceFailure): string {
  return WORDS[failure];
}
