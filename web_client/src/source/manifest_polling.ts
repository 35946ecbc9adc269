/** Follows a scene that grows in a folder of a web server: asks for its manifest again and again. */

import { parseManifest } from "../codec/manifest";
import { download } from "./download";
import { continues, type ManifestDocument } from "./growth";
import type { HttpSource } from "./http_source";

/** Between two looks, ms; doubled after every one that fails. */
const PAUSE = 2000;
const LONGEST_PAUSE = 30_000;

/**
 * Tell a source of every later version of its manifest, until the scene is complete; not while nobody sees the page.
 *
 * @param url of the manifest.
 */
export async function followManifest(
  source: Pick<HttpSource, "become" | "events" | "hidden">,
  url: string,
  manifest: ManifestDocument,
  signal: AbortSignal,
): Promise<void> {
  let pause = PAUSE;
  for (let last = manifest; last.live !== undefined && !signal.aborted; ) {
    await new Promise((resolve) => setTimeout(resolve, pause));
    if (source.hidden() || signal.aborted) continue;
    try {
      const { bytes } = await download(url, signal, "no-cache");
      const found: ManifestDocument = JSON.parse(new TextDecoder().decode(bytes));
      pause = PAUSE;
      if (signal.aborted || !continues(found, last)) continue; // a cache may answer with an earlier version
      const later = parseManifest(found);
      last = found;
      source.events.grown(later);
      source.become(later);
    } catch {
      pause = Math.min(LONGEST_PAUSE, 2 * pause);
    }
  }
}
