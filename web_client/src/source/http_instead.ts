/** HTTP in place of a stream: its availability, and a source without WebSockets. Loaded when a stream fails. */

import { GZIP, type OpenSource, type SourceFailure } from "./scene_source";

const PATIENCE = 10_000; // ms
const REMARK =
  "hgs: this site does not pass WebSockets; the scene is loaded over HTTP instead. See docs/deploy.md of the server.";

/**
 * Availability of a scene over HTTP: available; not available to anybody or to this visitor; or unknown, for want of an
 * answer.
 */
export type HttpAnswer = "there" | "away" | Extract<SourceFailure, "no-scene" | "no-access">;

/** The index of the scene with the stream `ws://host/v1/scenes/{scene}/stream`. */
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
      // A proxy's own page in place of the index begins with another byte.
      return new Uint8Array(await response.arrayBuffer())[0] === GZIP ? "there" : "away";
    }
    if (response.status === 401 || response.status === 403) return "no-access";
    const { code } = await response.json(); // fails for a proxy's page: only the server answers in JSON
    return code === "scene-not-found" ? "no-scene" : "away";
  } catch {
    return "away";
  }
}

/**
 * The source for a stream's scene from `openFiles`, given the address of its index and the query that grants access.
 */
export function openInstead(stream: string, openFiles: (index: string, query: string) => OpenSource): OpenSource {
  // biome-ignore lint/suspicious/noConsole: for the site's operator; visitors miss nothing
  console.info(REMARK);
  // The state stays `over-http` even when the source is closed.
  const open = openFiles(addressOf(stream).href, new URL(stream).search);
  return (events, playhead) =>
    open(
      { ...events, state: (state) => events.state(state === "open" || state === "closed" ? "over-http" : state) },
      playhead,
    );
}
