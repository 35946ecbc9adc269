import { beforeAll, describe, expect, it } from "vitest";
import { decompress, zstdReady } from "../../src/codec/zstd";

/** A frame of one block stored as it is (RFC 8878), which states its content size in one byte. */
const frame = (content: readonly number[], stated = content.length): number[] => [
  ...[0x28, 0xb5, 0x2f, 0xfd, 0x20, stated],
  ...[1 | ((content.length << 3) & 255), content.length >> 5, 0],
  ...content,
];

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
});
