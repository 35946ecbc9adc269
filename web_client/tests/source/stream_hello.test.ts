import { expect, it } from "vitest";
import { fromHex } from "../../src/protocol/messages";
import { PartialChunks } from "../../src/protocol/partial_chunks";
import { helloOf, type StreamState } from "../../src/source/stream_hello";

const [A, B, C] = ["aa", "bb", "cc"].map((byte) => byte.repeat(32));

const state = (fields: Partial<StreamState>): StreamState => ({
  playhead: { time: 0.5, rate: 1 },
  manifest: { id: null, grows: false, chunks: [] },
  sound: { wanted: false, sent: [] },
  have: new Set(),
  partial: new PartialChunks(),
  ...fields,
});

it("says at first where the playhead is, and nothing of what it has", () => {
  const { have_bits, ...hello } = helloOf(9000, state({}));
  expect(have_bits).toBeUndefined();
  expect(hello).toEqual({
    type: "hello",
    protocol: 2,
    credits: 9000,
    codings: ["gzip"],
    parts: [],
    time: 0.5,
    rate: 1,
    follow: true,
  });
});

it("leaves the time to the server where it knows none", () => {
  expect(helloOf(1, state({ playhead: { time: null, rate: 0 } }))).not.toHaveProperty("time");
});

it("marks what it has of a manifest that stays as it is, lowest bits first", () => {
  const id = new Uint8Array(32);
  const hello = helloOf(1, state({ manifest: { id, grows: false, chunks: [A, B, C] }, have: new Set([C, A]) }));
  expect(hello).toMatchObject({ have_bits: Uint8Array.of(0b101), manifest_id: id });
  expect(hello).not.toHaveProperty("have");
});

it("names what it has where the manifest may have become another one, and the sound if that is wanted", () => {
  const growing = { id: null, grows: true, chunks: [A, B] };
  const sound = { wanted: true, sent: [C] };
  expect(helloOf(1, state({ manifest: growing, have: new Set([A]) }))).toMatchObject({ have: [fromHex(A)] });
  const both = helloOf(1, state({ manifest: growing, have: new Set([A]), sound }));
  expect(both).toMatchObject({ have: [fromHex(C), fromHex(A)], audio: true });
  expect(both.have_bits).toBeUndefined();
});
