/** The choice of a source by a scene's address. */

import { HttpSource } from "./http_source";
import { openLate } from "./late_source";
import type { OpenSource } from "./scene_source";

/** A scene on a server of HGS: its page or its API address. */
const SERVED = /^(.*)\/(?:view|v1\/scenes)\/([A-Za-z0-9_-][A-Za-z0-9._-]{0,63})(?:\/|\/stream)?$/;

/** A scene in a folder of any web server: its index or manifest, or the folder itself. */
const FOLDER = /\/(?:[^/]*\.(?:json|hgs))?$/;

/**
 * Choose the source for an address. On a web server: an index (`….hgs`), a manifest (`….json`) or their folder (`…/`).
 * On a server of HGS: the scene's page `/view/{scene}`, its `/v1/scenes/{scene}`, or its stream (`ws:` or `wss:`).
 * Relative addresses are relative to the page.
 *
 * @throws Error with one line for people if the address is of none of these kinds.
 */
export function openSource(src: string, base: string = document.baseURI): OpenSource {
  const url = parse(src, base);
  if (/^wss?:$/.test(url.protocol)) return openStream(url.href);
  const served = SERVED.exec(url.pathname);
  if (!served) {
    if (!/^https?:$/.test(url.protocol) || !FOLDER.test(url.pathname)) {
      throw new Error(
        `src ${src}: not a manifest.json or index.hgs, a folder (…/), a scene of a server (/view/NAME) or a stream (wss:)`,
      );
    }
    return openFiles((url.pathname.endsWith("/") ? new URL("manifest.json", url) : url).href);
  }
  return openStream(streamUrl(served[2], { protocol: url.protocol, host: url.host + served[1] }) + url.search);
}

/**
 * Open a scene of files.
 *
 * @param query for every address, such as `?link=…`
 */
export function openFiles(manifest: string, query = ""): OpenSource {
  return (events, playhead) => new HttpSource(manifest, events, playhead, undefined, query);
}

function openStream(stream: string): OpenSource {
  return openLate(async () => {
    const { openServed } = await import("./served_source"); // not needed for folders
    return openServed(stream, openFiles);
  });
}

function parse(src: string, base: string): URL {
  try {
    return new URL(src, base);
  } catch {
    throw new Error(`src ${src}: not an address`);
  }
}

/** The address of a scene's stream on a server. */
export function streamUrl(scene: string, server: { protocol: string; host: string }): string {
  const scheme = server.protocol === "https:" ? "wss:" : "ws:";
  return `${scheme}//${server.host}/v1/scenes/${encodeURIComponent(scene)}/stream`;
}
