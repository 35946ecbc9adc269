import { expect, it, vi } from "vitest";
import { parseManifest } from "../../src/codec/manifest";
import { StreamedManifest } from "../../src/source/streamed_manifest";
import { GROWING, WHOLE } from "../worker_double";

const bytes = (document: unknown) => new TextEncoder().encode(JSON.stringify(document));
const ID = Uint8Array.of(1, 2);
const LATER = Uint8Array.of(1, 3);

/** A manifest of which the first version has come. */
function begun(document: unknown) {
  const events = { grown: vi.fn(), failed: vi.fn() };
  const manifest = new StreamedManifest(events);
  manifest.id = ID;
  manifest.begin(bytes(document));
  return { manifest, events };
}

it("names the chunks and the sound of what has come", () => {
  const { manifest } = begun({
    static: [{ id: "a" }],
    slices: [{ chunks: [{ id: "b" }, { id: "c" }] }],
    audio: { pieces: [{ id: "s" }] },
  });
  expect(manifest.chunks).toEqual(["a", "b", "c"]);
  expect(manifest.sounds).toEqual(["s"]);
  expect(manifest.grows).toBe(false);
});

it.each(["{", "3", "null", "{}"])("takes %s for a manifest without chunks: the player finds out", (json) => {
  const manifest = new StreamedManifest({ grown: vi.fn(), failed: vi.fn() });
  manifest.begin(new TextEncoder().encode(json));
  expect([manifest.chunks, manifest.sounds, manifest.grows]).toEqual([[], [], false]);
});

it("knows itself by its id", () => {
  const { manifest } = begun(WHOLE);
  expect([manifest.is(ID.slice()), manifest.is(LATER), manifest.is(Uint8Array.of(1))]).toEqual([true, false, false]);
  expect(new StreamedManifest({ grown: vi.fn(), failed: vi.fn() }).is(new Uint8Array())).toBe(false);
});

it("becomes a later version by what has been added, or by that version itself", () => {
  const { segments, slices, end, totals } = WHOLE;
  const { manifest, events } = begun(GROWING);
  expect(manifest.grows).toBe(true);
  const added = { live: 2, end, totals, segments: segments.slice(1), slices: slices.slice(GROWING.slices.length) };
  manifest.grow(bytes(added), LATER);
  expect(events.grown).toHaveBeenLastCalledWith(parseManifest({ ...WHOLE, live: 2 }));
  expect(manifest.is(LATER)).toBe(true);
  expect(manifest.chunks).toContain(slices.at(-1)?.chunks[0].id);
  manifest.become(bytes(WHOLE), Uint8Array.of(9));
  expect(events.grown).toHaveBeenLastCalledWith(parseManifest(WHOLE));
  expect([manifest.grows, events.failed.mock.calls]).toEqual([false, []]);
});

it("fails where it grows into what cannot be read", () => {
  const { manifest, events } = begun(GROWING);
  manifest.grow(bytes({ live: 2, title: 3, segments: [], slices: [] }), LATER);
  expect(events.failed).toHaveBeenCalledExactlyOnceWith("not-understood", expect.stringContaining("title"));
  expect([manifest.is(ID), events.grown.mock.calls]).toEqual([true, []]);
});

it("fails where it becomes another scene's", () => {
  const { manifest, events } = begun({ live: 1, end: 1, static: [], segments: [], slices: [] });
  manifest.grow(bytes({ live: 1, end: 2, segments: [], slices: [] }), LATER);
  manifest.become(bytes({ end: 0, static: [], segments: [], slices: [] }), LATER);
  expect(events.failed.mock.calls.map(([failure]) => failure)).toEqual(["scene-changed", "scene-changed"]);
});
