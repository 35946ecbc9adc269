import { readdirSync, readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { decodeChunk } from "../../src/codec/chunk";
import { crc32 } from "../../src/codec/crc32";
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

  it.each(["static", "dynamic"])("meets any damage of the %s vector with ChunkError", async (name) => {
    const original = bytesOf(`${name}.chunk`);
    let state = 1;
    const random = (below: number) => {
      state = (Math.imul(state, 1664525) + 1013904223) >>> 0; // a linear congruential generator: the same damage each run
      return Math.floor((state / 2 ** 32) * below);
    };
    let refused = 0;
    for (let round = 0; round < 1000; round++) {
      const bytes = original.slice();
      const reach = random(2) ? bytes.length : 64 + 44 * bytes[7];
      bytes[random(reach)] = random(256);
      new DataView(bytes.buffer).setUint32(bytes.length - 4, crc32(bytes.subarray(0, -4)), true);
      const error = await decodeChunk(bytes).then(
        () => undefined,
        (reason: unknown) => reason,
      );
      if (error === undefined) continue;
      expect(error).toBeInstanceOf(ChunkError);
      refused++;
    }
    expect(refused).toBeGreaterThan(300);
  });
});
