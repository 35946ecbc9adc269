/** What a source has of a scene's manifest: all of a short one, and of a long one the pages that have come. */

import { parseManifest } from "../codec/manifest";
import type { Manifest } from "../codec/types";

const GZIP = 0x1f; // the first byte

export interface SceneManifest {
  /** As far as it is here. In place of a page that is not there is a slice with one chunk, which is the page. */
  readonly manifest: Manifest;
  /** Of a manifest in pages: where they begin, and how many segments each has. */
  readonly places?: readonly (readonly [number, number])[];
  /** Whether there is such a page, and it has not come. */
  lacks?(id: string): boolean;
  /** Take a page that is lacking; resolves to false if it is none. Rejects with ManifestError if it is damaged. */
  add?(id: string, bytes: Uint8Array<ArrayBuffer>): Promise<boolean>;
  /** The pages that have come and will not change, with the ids of the chunks and of the sound that they list. */
  listed?(): [string, string[]][];
}

/**
 * Read a manifest, at once, or an index, for which there is a module of its own.
 *
 * @throws SyntaxError or ManifestError, or rejects with one or with another error, if it cannot be read
 */
export function readManifest(bytes: Uint8Array<ArrayBuffer>): SceneManifest | Promise<SceneManifest> {
  if (bytes[0] === GZIP) return import("./paged_manifest").then(({ readIndex }) => readIndex(bytes));
  return { manifest: parseManifest(JSON.parse(new TextDecoder().decode(bytes))) };
}
