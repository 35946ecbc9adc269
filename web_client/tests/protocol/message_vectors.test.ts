/** The viewer against tests/vectors/messages.json, which the server is tested against as well. */

import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { fromHex, toHex } from "../../src/codec/hex";
import {
  type ClientMessage,
  decodeChunkFrame,
  decodeMessage,
  encodeMessage,
  ProtocolError,
} from "../../src/protocol/messages";

interface Vector {
  readonly name: string;
  readonly bytes: string;
  readonly message: Record<string, unknown>;
}

const vectors = JSON.parse(readFileSync(new URL("../../../tests/vectors/messages.json", import.meta.url), "utf8"));

/** `{"hex": …}` as bytes, wherever it stands. */
function value(plain: unknown): unknown {
  if (Array.isArray(plain)) return plain.map(value);
  if (typeof plain !== "object" || plain === null) return plain;
  if ("hex" in plain) return fromHex(String(plain.hex));
  return Object.fromEntries(Object.entries(plain).map(([name, item]) => [name, value(item)]));
}

describe("the messages of the protocol's vectors", () => {
  it.each(vectors.client as Vector[])("$name of the client has these bytes", ({ bytes, message }) => {
    expect(toHex(encodeMessage(value(message) as ClientMessage))).toBe(bytes);
  });

  const ours = (vectors.server as Vector[]).filter(({ name }) => name !== "grow-of-version-2");
  it.each(ours)("$name of the server is read", ({ bytes, message }) => {
    expect(decodeMessage(fromHex(bytes))).toEqual(value(message));
  });

  it.each(vectors.refused_by_client as Vector[])("$name is refused", ({ bytes }) => {
    expect(() => decodeMessage(fromHex(bytes))).toThrow(ProtocolError);
  });

  it("has a chunk frame, which is read", () => {
    const { id, ...rest } = value(vectors.chunk_frame.frame) as { id: Uint8Array };
    expect(decodeChunkFrame(fromHex(vectors.chunk_frame.bytes))).toEqual({ id: toHex(id), ...rest });
  });
});
