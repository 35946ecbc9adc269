/** Why a stream is over for good: what the server's codes mean to whoever watches. */

import type { SourceFailure } from "./scene_source";

/** The server's error codes and close codes (docs/protocol.md, Closing) that have a meaning of their own. */
const MEANINGS: ReadonlyMap<string | number, SourceFailure> = new Map<string | number, SourceFailure>([
  ["scene-not-found", "no-scene"],
  [4004, "no-scene"],
  ["protocol-unsupported", "not-understood"],
  [4001, "not-understood"],
  ["malformed", "not-understood"],
  [4000, "not-understood"],
]);

/** @param code of an `error` message or of a close */
export function streamFailure(code: string | number): SourceFailure {
  return MEANINGS.get(code) ?? "ended";
}
