/** The sentences for the reasons of a source's end. */

import type { SourceFailure } from "../source/scene_source";

export const SOURCE_FAILURES: Readonly<Record<Exclude<SourceFailure, "not-loaded">, string>> = {
  "no-scene": "There is no such scene here. It may have been deleted.",
  "no-access": "To watch this scene you need a key, or a link that has not expired.",
  "access-ended":
    "You can no longer watch this scene: the key or link that opened it is no longer valid. Ask for a new one.",
  unreadable: "This page cannot read the scene. Reloading the page may help.",
  "scene-changed": "A new version of this scene has been published. Reload the page to see it.",
  "not-understood": "This page and the server have different versions. Reloading the page may help.",
  ended: "The server has ended the stream. Reloading the page may help.",
};
