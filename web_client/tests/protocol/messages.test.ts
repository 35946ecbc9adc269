import { decode, encode } from "@msgpack/msgpack";
import { describe, expect, it } from "vitest";
import { fromHex, toHex } from "../../src/codec/hex";
import { decodeChunkFrame, decodeMessage, encodeMessage, ProtocolError } from "../../src/protocol/messages";

const ID = "00ff".repeat(16);

/** A chunk frame written byte by byte from the table of docs/stream.md. */
function frame(offset: number, size: number, payload: number[]): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(48 + payload.length);
  const view = new DataView(bytes.buffer);
  view.setUint8(0, 1);
  view.setUint32(4, offset, true);
  view.setUint32(8, size, true);
  bytes.set(fromHex(ID), 16);
  bytes.set(payload, 48);
  return bytes;
}

describe("control messages", () => {
  it("encodes a hello as one map with string keys", () => {
    const parts: [Uint8Array, number][] = [[fromHex(ID), 5]];
    const pages: [Uint8Array, Uint8Array][] = [[fromHex(ID), Uint8Array.of(5)]];
    const hello = { type: "hello", protocol: 1, credits: 4096, pages, parts, time: 0.5, rate: 1 } as const;
    const bytes = encodeMessage(hello);
    expect(decode(bytes)).toEqual(hello);
    expect(bytes[0]).not.toBe(0x01);
  });

  it("decodes a welcome whose manifest is a view into the message", () => {
    const manifest = new Uint8Array([1, 2]);
    const manifest_id = new Uint8Array(32);
    const bytes = encode({ type: "welcome", protocol: 1, scene: "s", manifest, manifest_id, remaining: 9 });
    const message = decodeMessage(bytes);
    if (message?.type !== "welcome") throw new Error("not a welcome");
    expect(Array.from(message.manifest)).toEqual([1, 2]);
    expect(message.manifest.buffer).toBe(bytes.buffer);
  });

  it("ignores types and fields that it does not know", () => {
    expect(decodeMessage(encode({ type: "weather", sunny: true }))).toBeNull();
    expect(decodeMessage(encode({ type: "constructor" }))).toBeNull();
    expect(decodeMessage(encode({ type: "end", bytes: 1, mood: "fine" }))).toMatchObject({ type: "end", bytes: 1 });
  });

  it.each([
    ["a number", encode(7)],
    ["a list", encode([])],
    ["a map without a type", encode({ bytes: 1 })],
    ["a missing field", encode({ type: "end" })],
    ["a field of the wrong type", encode({ type: "end", bytes: "1" })],
    ["bytes that are cut off", encode({ type: "end", bytes: 1 }).subarray(0, 5)],
    ["nothing", new Uint8Array()],
  ])("refuses %s", (_, bytes) => {
    expect(() => decodeMessage(bytes)).toThrow(ProtocolError);
  });
});

describe("chunk frames", () => {
  it("decodes the header, and the payload without a copy", () => {
    const bytes = frame(10, 13, [7, 8, 9]);
    const { id, offset, size, payload } = decodeChunkFrame(bytes);
    expect({ id, offset, size }).toEqual({ id: ID, offset: 10, size: 13 });
    expect(Array.from(payload)).toEqual([7, 8, 9]);
    expect(payload.buffer).toBe(bytes.buffer);
  });

  it("refuses a frame without payload", () => {
    expect(() => decodeChunkFrame(frame(0, 3, []))).toThrow(ProtocolError);
  });

  it("refuses a frame that ends behind its chunk", () => {
    expect(() => decodeChunkFrame(frame(2, 4, [1, 2, 3]))).toThrow(ProtocolError);
  });
});

it("writes ids as hex and back", () => {
  expect(toHex(fromHex(ID))).toBe(ID);
});
