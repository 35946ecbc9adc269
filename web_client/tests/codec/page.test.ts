import { expect, it } from "vitest";
import { fromHex } from "../../src/codec/hex";
import { parseManifest } from "../../src/codec/manifest";
import { readPage } from "../../src/codec/page";
import { MANIFEST, PAGED, REFUSED } from "../page_vectors";

const whole = parseManifest(MANIFEST);

it("holds what the manifest says of its segments", async () => {
  const [first, second] = await Promise.all(PAGED.pages.map(({ bytes }) => readPage(bytes)));
  expect([...first.segments, ...second.segments]).toEqual(whole.segments);
  const moved = second.slices.map((slice) => ({ ...slice, segment: slice.segment + 2 }));
  expect([...first.slices, ...moved]).toEqual(whole.slices);
  expect([...first.pieces, ...second.pieces]).toEqual(MANIFEST.audio.pieces);
});

it.each(Object.entries(REFUSED as Record<string, string>))("refuses what is %s", async (_, page) => {
  await expect(readPage(fromHex(page))).rejects.toThrow("page:");
});
