import { readdirSync, readFileSync } from "node:fs";
import fc from "fast-check";
import { describe, expect, it } from "vitest";
import { crc32 } from "../../src/codec/crc32";
import { decodeChunk } from "../../src/codec/decode";
import { ChunkError } from "../../src/codec/errors";

const VECTORS = new URL("../../../tests/vectors/", import.meta.url);

interface Expected {
  kind: string;
  count: number;
  time_range: number[];
  box: number[][];
  bounds: Record<string, number>;
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
    expect(chunk.bounds).toEqual(expected.bounds);
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

  it.each(["static", "dynamic"])(
    "meets any damage of the %s vector with ChunkError",
    async (name) => {
      const original = bytesOf(`${name}.chunk`);
      const place = fc.nat(original.length - 1);
      const change = fc.tuple(place, fc.constantFrom("bit", "byte", "word", "cut", "grow"), fc.nat(2 ** 32 - 1));
      let refused = 0;
      await fc.assert(
        fc.asyncProperty(fc.array(change, { minLength: 1, maxLength: 3 }), async (changes) => {
          const bytes = sealed(changes.reduce(damaged, original));
          const result = await decodeChunk(bytes).catch((reason: unknown) => reason);
          if (result instanceof Error) {
            expect(result).toBeInstanceOf(ChunkError);
            refused++;
          } else {
            const arrays = Object.values(result as object).filter((value) => value instanceof Float32Array);
            expect(arrays.every((array) => array.every(Number.isFinite))).toBe(true);
          }
        }),
        { numRuns: 500, seed: 1 },
      );
      expect(refused).toBeGreaterThan(250);
    },
    60_000,
  );

  it("refuses every truncation", async () => {
    const original = bytesOf("dynamic.chunk");
    for (let length = 0; length < original.length; length += 7) {
      await expect(decodeChunk(original.subarray(0, length))).rejects.toBeInstanceOf(ChunkError);
    }
  }, 60_000);
});

type Change = [at: number, how: string, value: number];

/** The bytes with one change; the stated length follows when some are lost or gained. */
function damaged(bytes: Uint8Array, [place, how, value]: Change): Uint8Array {
  const at = place % bytes.length;
  let changed = bytes.slice();
  if (how === "bit") changed[at] ^= 1 << (value & 7);
  else if (how === "byte") changed[at] = value & 255;
  else if (how === "word") changed.set(new Uint8Array(Uint32Array.of(value).buffer).subarray(0, bytes.length - at), at);
  else if (how === "cut") changed = Uint8Array.of(...bytes.subarray(0, at), ...bytes.subarray(at + (value % 40)));
  else changed = Uint8Array.of(...bytes.subarray(0, at), value & 255, value & 255, ...bytes.subarray(at));
  if (changed.length >= 20 && changed.length !== bytes.length)
    new DataView(changed.buffer).setUint32(16, changed.length, true);
  return changed;
}

/** Makes the checksum right again, so that the fault behind it is met. */
function sealed(bytes: Uint8Array): Uint8Array {
  if (bytes.length >= 4) new DataView(bytes.buffer).setUint32(bytes.length - 4, crc32(bytes.subarray(0, -4)), true);
  return bytes;
}
