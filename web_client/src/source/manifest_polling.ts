/** Follows a scene that grows in a folder of a web server: asks for its manifest again and again. */

import { download } from "./download";
import { continues, type ManifestDocument } from "./growth";

/** Between two looks, ms; doubled after every one that fails. */
const PAUSE = 2000;
const LONGEST_PAUSE = 30_000;

/**
 * Tell `grown` of every later version of a manifest, until the scene is complete.
 *
 * @param url of the manifest.
 * @param hidden whether nobody sees the page: then nothing is fetched.
 */
export async function followManifest(
  url: string,
  manifest: ManifestDocument,
  signal: AbortSignal,
  hidden: () => boolean,
  grown: (document: ManifestDocument) => void,
): Promise<void> {
  let pause = PAUSE;
  for (let last = manifest; last.live !== undefined && !signal.aborted; ) {
    await new Promise((resolve) => setTimeout(resolve, pause));
    if (hidden() || signal.aborted) continue;
    try {
      const { bytes } = await download(url, signal, "no-cache");
      const found: ManifestDocument = JSON.parse(new TextDecoder().decode(bytes));
      pause = PAUSE;
      if (signal.aborted || !continues(found, last)) continue; // a cache may answer with an earlier version
      last = found;
      grown(found);
    } catch {
      pause = Math.min(LONGEST_PAUSE, 2 * pause);
    }
  }
}
