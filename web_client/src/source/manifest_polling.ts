/** Polling of the index or manifest of a growing scene in a folder of a web server. */

import { download } from "./download";
import { continues, readIndex } from "./paged_manifest";
import type { SceneManifest } from "./scene_source";

/** Pause between two requests, ms; doubled after each failure. */
const PAUSE = 2000;
const LONGEST_PAUSE = 30_000;

/** A source of a growing scene. */
interface Follower {
  /** Take a later version of the manifest. */
  become(found: SceneManifest): void;
  /** Whether the page is hidden. */
  hidden(): boolean;
}

/**
 * Pass every later version of the manifest to a source, until the scene is complete; nothing is requested while the
 * page is hidden.
 *
 * @param url of the index or manifest.
 */
export async function followManifest(
  source: Follower,
  url: string,
  first: SceneManifest,
  signal: AbortSignal,
): Promise<void> {
  let pause = PAUSE;
  for (let last = first; last.manifest.live !== null && !signal.aborted; ) {
    await new Promise((resolve) => setTimeout(resolve, pause));
    if (source.hidden() || signal.aborted) continue;
    try {
      const { bytes } = await download(url, signal, "no-cache");
      const found = await readIndex(bytes, last);
      pause = PAUSE;
      if (signal.aborted || !continues(found, last)) continue; // a cache may answer with an earlier version
      last = found;
      source.become(found);
    } catch {
      pause = Math.min(LONGEST_PAUSE, 2 * pause);
    }
  }
}
