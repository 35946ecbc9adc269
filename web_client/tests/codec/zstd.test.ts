import { beforeAll, describe, expect, it } from "vitest";
import { decompress, zstdReady } from "../../src/codec/zstd";

/** A frame of one block stored as it is (RFC 8878), which states its content size in one byte. */
const frame = (content: readonly number[], stated = content.length): number[] => [
  ...[0x28, 0xb5, 0x2f, 0xfd, 0x20, stated],
  ...[1 | ((content.length << 3) & 255), content.length >> 5, 0],
  ...content,
];

/** A frame of one block that repeats a byte. */
const run = (byte: number, length: number): number[] => [
  ...[0x28, 0xb5, 0x2f, 0xfd, 0xa0, length & 255, (length >> 8) & 255, length >> 16, 0],
  ...[3 | ((length << 3) & 255), (length >> 5) & 255, length >> 13, byte],
];

/** The last 32 bits of XXH64 of the bytes 1, 2, 3; from zstandard 0.25 for Python, as is PACKED. */
const CHECKSUM = [165, 229, 78, 12];

/** A frame of one block with Huffman codes and sequences. */
const PACKED = Buffer.from(
  "KLUv/WCQAI0JAAZZSwxA8APxQ985B+PkAcFHAEcARwAcwhhMatcSqCMZN69NsYqm440nQMqqXyquKaDTI+0x9BSj4Nuukera6losXgHeHKW/0FFVDTJY" +
    "O8uT4axrPzeiuhaLERABENcy4kp/RbuXA2DooiA0WNVnp3/bef2UJcZKuVjO01e46mllm7mI4LmJoxzJWRgloZoJMfRhrONk7/PwMG6DdxdAGGea0UAB" +
    "ScfVlPjir2cOVe5M8PHnocTvpk26kZ3UGHICVANACKEoDsmplI6u6xNO/d2iit08oPYWl+uHBLKMnxWUN7RPIsqEjK7RfwJ6P9dnRTPzKlOhCocul/TV" +
    "vcBQa9pdcTR5Km392PBE3KiabDC4PBrNPm9Hd1wVOrgkxPenmeW2M+REYJXnIUo8J2PXXk0A",
  "base64",
);
const UNPACKED = Uint8Array.from({ length: 400 }, (_, i) => ((Math.floor((i * i) / 7) % 37) + (i % 11) * (i % 3)) % 64);

/** Byte arrays that follow each other in one buffer. */
function joined(...parts: number[][]): Uint8Array[] {
  const bytes = Uint8Array.from(parts.flat());
  let end = 0;
  return parts.map(({ length }) => {
    end += length;
    return bytes.subarray(end - length, end);
  });
}

describe("decompress", () => {
  beforeAll(zstdReady);

  it("gives the contents of frames one after the other", () => {
    expect([...(decompress(joined(frame([1, 2, 3]), frame([4, 5, 6])), 3) as Uint8Array)]).toEqual([1, 2, 3, 4, 5, 6]);
  });

  it.each([
    ["states another size", frame([4, 5])],
    ["holds less than it states", frame([4, 5], 3)],
    ["holds more than it states", frame([4, 5, 6, 7], 3)],
    ["is followed by an empty frame", [...frame([4, 5, 6]), ...frame([])]],
    ["is followed by a byte", [...frame([4, 5, 6]), 0]],
    ["is cut off", frame([4, 5, 6]).slice(0, -1)],
    ["has a block of a reserved type", frame([4, 5, 6]).map((byte, i) => (i === 6 ? byte | 6 : byte))],
    ["is empty", []],
  ])("names the frame that %s", (_, bad) => {
    expect(decompress(joined(frame([1, 2, 3]), bad, frame([7, 8, 9])), 3)).toBe(1);
  });

  it("names the first of two bad frames, of whichever fault", () => {
    const [held, cut] = [frame([4, 5], 3), [...frame([7, 8, 9]), 0]];
    expect(decompress(joined(frame([1, 2, 3]), held, cut), 3)).toBe(1);
    expect(decompress(joined(frame([1, 2, 3]), cut, held), 3)).toBe(1);
  });

  it("refuses a frame whose content is not what its checksum says", () => {
    const checked = [...frame([1, 2, 3]).map((byte, i) => (i === 4 ? byte | 4 : byte)), ...CHECKSUM];
    expect(decompress(joined(checked), 3)).toEqual(Uint8Array.of(1, 2, 3));
    expect(decompress(joined(checked.map((byte, i) => (i === 9 ? 7 : byte))), 3)).toBe(0);
  });

  it("takes more than its memory holds at first", () => {
    const length = 100_000;
    const frames = joined(...Array.from({ length: 40 }, (_, i) => run(i, length)));
    const contents = decompress(frames, length) as Uint8Array;
    expect(contents).toHaveLength(frames.length * length);
    expect(frames.map((_, i) => contents[(i + 1) * length - 1])).toEqual(frames.map((_, i) => i));
  });

  it("unpacks codes and sequences, and lives on after any damage to them", () => {
    for (let i = 0; i < 8 * PACKED.length; i++) {
      const damaged = PACKED.map((byte, place) => (place === i >> 3 ? byte ^ (1 << (i & 7)) : byte));
      const contents = decompress(joined([...damaged]), UNPACKED.length);
      if (contents !== 0) expect(contents).toHaveLength(UNPACKED.length);
    }
    expect(decompress(joined([...PACKED]), UNPACKED.length)).toEqual(UNPACKED);
  });
});
