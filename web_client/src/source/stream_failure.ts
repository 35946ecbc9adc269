/** Why a stream is over for good: what the server's codes mean to whoever watches. */

import type { SourceFailure } from "./scene_source";

/** The server's error codes, and the close codes of those that come without one (docs/stream.md, Closing). */
const MEANINGS: Readonly<Record<string | number, SourceFailure>> = {
  "scene-not-found": "no-scene",
  4004: "no-scene",
  "scene-changed": "scene-changed",
  "access-ended": "access-ended",
  4003: "access-ended",
  "protocol-unsupported": "not-understood",
  4001: "not-understood",
  malformed: "not-understood",
  4000: "not-understood",
  "not-binary": "not-understood",
  1003: "not-understood",
  "message-too-large": "not-understood",
  1009: "not-understood",
  "credit-overflow": "not-understood",
  4009: "not-understood",
  flood: "ended",
};

/** @param code of an `error` message or of a close */
export function streamFailure(code: string | number): SourceFailure {
  return Object.hasOwn(MEANINGS, code) ? MEANINGS[code] : "ended";
}
