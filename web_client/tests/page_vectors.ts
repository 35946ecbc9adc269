/** tests/vectors/pages.json, against which the codec in Python is tested as well. */

import { readFileSync } from "node:fs";
import { gunzipSync } from "node:zlib";
import { fromHex } from "../src/codec/hex";

interface Vector {
  readonly index: string;
  readonly pages: Readonly<Record<string, string>>;
}

const vectors = JSON.parse(readFileSync(new URL("../../tests/vectors/pages.json", import.meta.url), "utf8"));

/** As JSON: three segments with sound, of which a page holds two. */
export const { manifest: MANIFEST, refused: REFUSED } = vectors;

const read = ({ index, pages }: Vector) => ({
  bytes: fromHex(index),
  index: JSON.parse(gunzipSync(fromHex(index)).toString()),
  pages: Object.entries(pages).map(([id, page]) => ({ id, bytes: fromHex(page) })),
});

export const PAGED = read(vectors.whole);
/** The same scene while it has its first segment alone. */
export const BEGINNING = read(vectors.beginning);
