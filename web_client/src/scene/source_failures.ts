/** Why a source has ended, for people. */

import type { SourceFailure } from "../source/scene_source";

export const SOURCE_FAILURES: Readonly<Record<Exclude<SourceFailure, "not-loaded">, string>> = {
  "no-scene": "There is no such scene here. It may have been taken away.",
  "no-access": "This scene is watched with a key, or with a link that still holds.",
  "access-ended":
    "You can watch this scene no longer: the key or link that opened it holds no more. Ask for a new one.",
  unreadable: "This page cannot read the scene. Loading the page again may help.",
  "scene-changed": "This scene has been published anew. Load the page again to see it.",
  "not-understood": "This page and the server are of different versions. Loading the page again may help.",
  ended: "The server has ended the stream. Loading the page again may help.",
};
