import { describe, expect, it } from "vitest";
import { parseManifest } from "../../src/codec/manifest";
import { continues, PagedManifest, readIndex } from "../../src/source/paged_manifest";
import { BEGINNING, MANIFEST, PAGED } from "../page_vectors";
import { GROWING, WHOLE } from "../worker_double";

const [FIRST, SECOND] = PAGED.pages;
const whole = parseManifest(MANIFEST);
const text = (document: unknown) => new TextEncoder().encode(JSON.stringify(document));

async function beginning(): Promise<PagedManifest> {
  const paged = new PagedManifest(BEGINNING.index);
  await paged.add(BEGINNING.pages[0].id, BEGINNING.pages[0].bytes);
  return paged;
}

it("is the manifest once all pages have come, in any order", async () => {
  const paged = new PagedManifest(PAGED.index);
  for (const { id, bytes } of [SECOND, FIRST]) {
    expect(paged.lacks(id)).toBe(true);
    expect(await paged.add(id, bytes)).toBe(true);
    expect(paged.lacks(id)).toBe(false);
    expect(await paged.add(id, bytes)).toBe(false);
  }
  const { room, ...manifest } = paged.manifest;
  expect(manifest).toEqual(whole);
  expect(room).toEqual({ all: { chunks: 24, splats: 108 }, most: { chunks: 6, splats: 30 } });
});

it("has a slice that needs the page where one has not come, and the segments as they are counted", async () => {
  const paged = new PagedManifest(PAGED.index);
  await paged.add(SECOND.id, SECOND.bytes);
  const { slices, segments, audio } = paged.manifest;
  expect(slices[0]).toMatchObject({ segment: 0, start: 0, end: 4, needs: [] });
  expect(slices[0].chunks).toMatchObject([{ id: FIRST.id, bytes: FIRST.bytes.length, splats: 0 }]);
  expect(slices.slice(1)).toEqual(whole.slices.slice(8));
  expect([segments.length, segments[2]]).toEqual([3, { start: 4, end: 6 }]);
  expect(audio).toEqual({ ...MANIFEST.audio, pieces: MANIFEST.audio.pieces.slice(5) });
});

it("shows an earlier version of a page until the later one has come", async () => {
  const before = await beginning();
  const later = new PagedManifest(PAGED.index, before);
  expect(later.lacks(FIRST.id)).toBe(true);
  expect(later.manifest.slices.slice(0, 4)).toEqual(whole.slices.slice(0, 4));
  expect(later.manifest.slices[4]).toMatchObject({ segment: 1, start: 2, end: 4, chunks: [{ id: FIRST.id }] });
  for (const { id, bytes } of PAGED.pages) await later.add(id, bytes);
  expect(later.manifest.slices).toEqual(whole.slices);
});

it("lists what its pages name, but not of the last page of a scene that grows", async () => {
  const paged = new PagedManifest(PAGED.index);
  await paged.add(SECOND.id, SECOND.bytes);
  const names = whole.slices.slice(8).flatMap(({ chunks }) => chunks.map(({ id }) => id));
  const sounds = MANIFEST.audio.pieces.slice(5).map(({ id }: { id: string }) => id);
  expect(paged.listed()).toEqual([[SECOND.id, [...names, ...sounds]]]);
  expect((await beginning()).listed()).toEqual([]);
});

it("refuses a page that is damaged, or not what the index says", async () => {
  const { id, bytes } = FIRST;
  await expect(new PagedManifest(PAGED.index).add(id, bytes.slice(0, -9))).rejects.toThrow("page: is damaged");
  const pages = PAGED.index.pages.map((row: object) => ({ ...row, segments: 3 }));
  await expect(new PagedManifest({ ...PAGED.index, pages }).add(id, bytes)).rejects.toThrow("not what the index says");
});

it.each([
  { version: 2 },
  { pages: [] },
  { pages: [{ id: "x", bytes: 1, start: 0, segments: 1 }] },
  { room: {} },
  { manifest: {} },
])("refuses an index with %o", (change) => {
  expect(() => new PagedManifest({ ...PAGED.index, ...change })).toThrow("index.");
});

it("reads an index in gzip or as it is, and a manifest in its place", async () => {
  const packed = await readIndex(PAGED.bytes);
  expect(packed.manifest).toEqual((await readIndex(text(PAGED.index))).manifest);
  expect(packed.lacks?.(FIRST.id)).toBe(true);
  expect(readIndex(text(MANIFEST))).toEqual({ manifest: whole });
});

const first = { manifest: parseManifest(GROWING) };
const last = { manifest: parseManifest(WHOLE) };
const changed = (fields: object) => ({ manifest: { ...last.manifest, ...fields } });

describe("continues", () => {
  it("is true of a later version alone", () => {
    expect(continues(last, first)).toBe(true);
    expect(continues(changed({ live: 2 }), first)).toBe(true);
    expect(continues(changed({ live: 1 }), first)).toBe(false);
    expect(continues(first, first)).toBe(false);
    expect(continues(first, last)).toBe(false);
  });

  it("is false where anything that was there is another", () => {
    const { static: stills, slices, segments } = last.manifest;
    expect(continues(changed({ end: 0.5 }), first)).toBe(false);
    expect(continues(changed({ static: stills.slice(1) }), first)).toBe(false);
    expect(continues(changed({ static: [...stills, stills[0]] }), first)).toBe(false);
    expect(continues(changed({ slices: [...slices].reverse() }), first)).toBe(false);
    expect(continues(changed({ segments: segments.slice(1) }), first)).toBe(false);
  });

  it("is true of a manifest in pages where the last one has become longer, or there are none any more", () => {
    const before = new PagedManifest(BEGINNING.index);
    expect(continues(new PagedManifest(PAGED.index), before)).toBe(true);
    expect(continues({ manifest: parseManifest(MANIFEST) }, before)).toBe(true);
    expect(continues(before, before)).toBe(false);
  });

  it("is false of pages that begin elsewhere", () => {
    const [row, ...rest] = PAGED.index.pages;
    const live = { ...PAGED.index.manifest, live: 1 };
    const before = new PagedManifest({ ...PAGED.index, manifest: live });
    expect(continues(new PagedManifest(PAGED.index), before)).toBe(true);
    expect(continues(new PagedManifest({ ...PAGED.index, pages: [{ ...row, start: 1 }, ...rest] }), before)).toBe(
      false,
    );
  });
});
