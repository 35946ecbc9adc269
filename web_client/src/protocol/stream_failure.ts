/** Why a stream is over for good: what the server's codes mean to whoever watches. */

/** The scene is not there; it is another one than before; page and server are of different versions; anything else. */
export type StreamFailure = "no-scene" | "scene-changed" | "not-understood" | "ended";

/** The server's error codes and close codes (docs/protocol.md, Closing) that have a meaning of their own. */
const MEANINGS: ReadonlyMap<string | number, StreamFailure> = new Map<string | number, StreamFailure>([
  ["scene-not-found", "no-scene"],
  [4004, "no-scene"],
  ["protocol-unsupported", "not-understood"],
  [4001, "not-understood"],
  ["malformed", "not-understood"],
  [4000, "not-understood"],
]);

/** @param code of an `error` message or of a close */
export function streamFailure(code: string | number): StreamFailure {
  return MEANINGS.get(code) ?? "ended";
}
