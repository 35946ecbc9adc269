/** A served scene by HTTP alone: whether it can be had so, and from where. Loaded when its stream does not come about. */

import { GZIP, type OpenSource, type SourceFailure } from "./scene_source";

const PATIENCE = 10_000; // ms
const REMARK =
  "hgs: this site does not pass WebSockets; the scene is loaded over HTTP instead. See docs/deploy.md of the server.";

/** The scene can be had over HTTP; it can by nobody, or not by this visitor; or nobody knows, as the server does not answer. */
export type HttpAnswer = "there" | "away" | Extract<SourceFailure, "no-scene" | "no-access">;

/** The index of the scene whose stream is `ws://host/v1/scenes/{scene}/stream`. */
function addressOf(stream: string): URL {
  return new URL("index.hgs", stream.replace(/^ws/, "http"));
}

export async function askOverHttp(stream: string, signal: AbortSignal): Promise<HttpAnswer> {
  const address = addressOf(stream);
  address.search = new URL(stream).search;
  try {
    const response = await fetch(address, {
      signal: AbortSignal.any([signal, AbortSignal.timeout(PATIENCE)]),
      cache: "no-cache",
    });
    if (response.status === 200) {
      // A proxy's own page in place of the index begins otherwise.
      return new Uint8Array(await response.arrayBuffer())[0] === GZIP ? "there" : "away";
    }
    if (response.status === 401 || response.status === 403) return "no-access";
    const { code } = await response.json(); // a server's own answer: a proxy's page is none
    return code === "scene-not-found" ? "no-scene" : "away";
  } catch {
    return "away";
  }
}

/** The scene of a stream as `openFiles` brings it, by the address of its index and the query that opens it. */
export function openInstead(stream: string, openFiles: (index: string, query: string) => OpenSource): OpenSource {
  // biome-ignore lint/suspicious/noConsole: for who runs the site; a visitor misses nothing
  console.info(REMARK);
  // Also when all is here and the source is closed: it stays worth knowing.
  const open = openFiles(addressOf(stream).href, new URL(stream).search);
  return (events, playhead) =>
    open(
      { ...events, state: (state) => events.state(state === "open" || state === "closed" ? "over-http" : state) },
      playhead,
    );
}
