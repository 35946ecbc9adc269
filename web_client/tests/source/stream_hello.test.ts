import { expect, it } from "vitest";
import { fromHex } from "../../src/codec/hex";
import { PartialChunks } from "../../src/protocol/partial_chunks";
import { helloOf, type StreamState } from "../../src/source/stream_hello";

const [A, B, C, D, PAGE] = ["aa", "bb", "cc", "dd", "ee"].map((byte) => byte.repeat(32));

const state = (fields: Partial<StreamState>): StreamState => ({
  playhead: { time: 0.5, rate: 1 },
  id: null,
  pages: [],
  sound: { wanted: false, sent: [] },
  have: new Set(),
  partial: new PartialChunks(),
  ...fields,
});

it("says at first where the playhead is, and nothing of what it has", () => {
  expect(helloOf(9000, state({}))).toEqual({
    type: "hello",
    protocol: 1,
    credits: 9000,
    parts: [],
    time: 0.5,
    rate: 1,
    follow: true,
  });
});

it("leaves the time to the server where it knows none", () => {
  expect(helloOf(1, state({ playhead: { time: null, rate: 0 } }))).not.toHaveProperty("time");
});

it("names pages with a bit for each chunk that they list, lowest bits first, and all else by its id", () => {
  const id = new Uint8Array(32);
  const pages = [[PAGE, [A, B, C]]] as const;
  const hello = helloOf(1, state({ id, pages, have: new Set([C, A, D]) }));
  expect(hello).toMatchObject({ manifest_id: id, pages: [[fromHex(PAGE), Uint8Array.of(0b101)]], have: [fromHex(D)] });
});

it("names its sound if that is wanted", () => {
  const sound = { wanted: true, sent: [C] };
  const both = helloOf(1, state({ have: new Set([A]), sound }));
  expect(both).toMatchObject({ have: [fromHex(C), fromHex(A)], audio: true });
  const paged = helloOf(1, state({ pages: [[PAGE, [A, C]]], have: new Set([A]), sound }));
  expect(paged).toMatchObject({ pages: [[fromHex(PAGE), Uint8Array.of(0b11)]] });
  expect(paged).not.toHaveProperty("have");
});
