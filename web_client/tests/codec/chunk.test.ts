import { readdirSync, readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { decodeChunk } from "../../src/codec/chunk";
import { ChunkError } from "../../src/codec/errors";

const VECTORS = new URL("../../../tests/vectors/", import.meta.url);

interface Expected {
  kind: string;
  count: number;
  time_range: number[];
  box: number[][];
  float32: Record<string, string>;
}

function bytesOf(name: string): Uint8Array {
  return new Uint8Array(readFileSync(new URL(name, VECTORS)));
}

function json<T>(name: string): T {
  return JSON.parse(readFileSync(new URL(name, VECTORS), "utf8")) as T;
}

const valid = readdirSync(VECTORS)
  .filter((file) => file.endsWith(".chunk"))
  .map((file) => file.slice(0, -".chunk".length));

describe("decodeChunk", () => {
  it.each(valid)("gives the bits of the Python decoder for %s", async (name) => {
    const chunk = await decodeChunk(bytesOf(`${name}.chunk`));
    const expected = json<Expected>(`${name}.json`);
    expect(chunk.kind).toBe(expected.kind);
    expect(chunk.count).toBe(expected.count);
    expect(chunk.timeRange).toEqual(expected.time_range);
    expect([chunk.box.min, chunk.box.max]).toEqual(expected.box);
    for (const [snake, base64] of Object.entries(expected.float32)) {
      const key = snake.replace(/_(.)/g, (_, letter: string) => letter.toUpperCase());
      const array = (chunk as unknown as Record<string, Float32Array>)[key];
      expect(Buffer.from(array.buffer).toString("base64"), key).toBe(base64);
    }
  });

  it.each(Object.entries(json<Record<string, object>>("invalid.json")))("refuses %s", async (name, expected) => {
    const error = await decodeChunk(bytesOf(`invalid/${name}.chunk`)).catch((reason: unknown) => reason);
    expect(error).toBeInstanceOf(ChunkError);
    const { byte, record } = error as ChunkError;
    expect({ byte, record }).toEqual(expected);
  });
});
