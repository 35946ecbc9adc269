import { decode, encode } from "@msgpack/msgpack";
import fc from "fast-check";
import { describe, expect, it } from "vitest";
import { type Packable, pack, unpack } from "../../src/protocol/msgpack";

/** But for `__proto__`, which the library refuses. */
const keys = fc.string().filter((key) => key !== "__proto__");

/** Whatever a message may hold, deep and wide. */
const values = fc.letrec<{ value: Packable }>((tie) => ({
  value: fc.oneof(
    { maxDepth: 3 },
    fc.constant(null),
    fc.boolean(),
    fc.double().map((value) => (value === 0 ? 0 : value)), // the library packs -0 as 0
    fc.maxSafeInteger(),
    fc.integer({ min: -40, max: 300 }),
    fc.string({ unit: "binary", maxLength: 300 }),
    fc.uint8Array({ maxLength: 300 }),
    fc.array(tie("value"), { maxLength: 20 }),
    fc.dictionary(keys, tie("value"), { maxKeys: 20, noNullPrototype: true }),
  ),
})).value;

const plain = (value: unknown) => JSON.parse(JSON.stringify(value));

describe("against the library @msgpack/msgpack", () => {
  it("packs what the library unpacks to the same", () => {
    fc.assert(
      fc.property(values, (value) => {
        expect(plain(decode(pack(value)))).toEqual(plain(value));
      }),
    );
  });

  it("unpacks what the library packs", () => {
    fc.assert(
      fc.property(values, (value) => {
        expect(plain(unpack(encode(value)))).toEqual(plain(value));
      }),
    );
  });

  it("packs in as few bytes, but for numbers below -32", () => {
    const few = fc.oneof(
      fc.maxSafeInteger().map((n) => (n < -32 ? -n : n)),
      fc.string({ unit: "binary" }),
      fc.uint8Array(),
    );
    fc.assert(
      fc.property(few, (value) => {
        expect([...pack(value)]).toEqual([...encode(value)]);
      }),
    );
  });

  it.each([15, 16, 31, 32, 255, 256, 65535, 65536])("agrees about lengths of %i", (length) => {
    for (const value of [
      "x".repeat(length),
      new Uint8Array(length),
      new Array(length).fill(7),
      Object.fromEntries(Array.from({ length }, (_, i) => [String(i), i])),
    ]) {
      expect(Buffer.from(pack(value)).equals(Buffer.from(encode(value)))).toBe(true);
      expect(unpack(encode(value))).toEqual(value);
    }
  });

  it("takes a key that is called __proto__ for a field like any other", () => {
    const bytes = pack(Object.fromEntries([["__proto__", 7]]));
    expect(Object.entries(unpack(bytes) as object)).toEqual([["__proto__", 7]]);
    expect(Object.getPrototypeOf(unpack(bytes))).toBe(Object.prototype);
  });

  it("unpacks numbers of every width", () => {
    for (const value of [-33, -129, -32769, -(2 ** 31), -(2 ** 40), 2 ** 40, Number.MAX_SAFE_INTEGER, 0.1]) {
      expect(unpack(encode(value))).toBe(value);
    }
    expect(unpack(encode(0.5, { forceFloat32: true }))).toBe(0.5);
  });

  it("takes no value that is cut off or goes on", () => {
    fc.assert(
      fc.property(values, fc.nat(), (value, place) => {
        const bytes = encode(value);
        expect(() => unpack(bytes.subarray(0, place % bytes.length))).toThrow(RangeError);
        expect(() => unpack(Uint8Array.of(...bytes, 0))).toThrow("1 bytes after the value");
      }),
    );
  });
});

it("leaves out fields that are undefined", () => {
  expect(unpack(pack({ a: 1, b: undefined }))).toEqual({ a: 1 });
});

it("passes over extensions", () => {
  expect(unpack(Uint8Array.of(0x92, 0xd4, 5, 0, 7))).toEqual([undefined, 7]);
  expect(unpack(Uint8Array.of(0x92, 0xc7, 2, 5, 0, 0, 7))).toEqual([undefined, 7]);
});

it("takes a field of any name for a field", () => {
  const message = unpack(Uint8Array.of(0x81, 0xa9, ...new TextEncoder().encode("__proto__"), 7));
  expect(Object.entries(message as object)).toEqual([["__proto__", 7]]);
});

it("takes no other types, no other names and no text that is none", () => {
  expect(() => unpack(Uint8Array.of(0xc1))).toThrow("0xc1 is no type");
  expect(() => unpack(Uint8Array.of(0x81, 7, 7))).toThrow("7 is no name of a field");
  expect(() => unpack(Uint8Array.of(0xa1, 0xff))).toThrow();
});
