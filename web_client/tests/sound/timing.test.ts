import { describe, expect, it } from "vitest";
import { Alignment, partToHear, pieceAt } from "../../src/sound/timing";

const PIECES = [
  { id: "a", start: -0.01, end: 1.0 },
  { id: "b", start: 0.999, end: 2.0 },
  { id: "c", start: 3.0, end: 4.0 },
];

describe("pieceAt", () => {
  it.each([
    [-5, 0],
    [0, 0],
    [1.0, 1],
    [2.0, 2], // silence: the next one
    [3.5, 2],
    [4.0, -1],
  ])("at %d s is the one that sounds, or the next", (time, index) => {
    expect(pieceAt(PIECES, time)).toBe(index);
  });
});

describe("partToHear", () => {
  const line = { zero: 10, rate: 2 }; // the scene's second s is heard at 10 + s / 2

  it("is the whole piece before it begins, up to where the next one does", () => {
    expect(partToHear(PIECES, 0, line, 9)).toEqual({ when: 9.995, from: -0.01, until: 0.999 });
  });

  it("is what is left of it later", () => {
    expect(partToHear(PIECES, 1, line, 10.75)).toEqual({ when: 10.75, from: 1.5, until: 2.0 });
  });

  it("is nothing when it is over", () => {
    expect(partToHear(PIECES, 1, line, 11)).toBeNull();
  });
});

describe("Alignment", () => {
  it("keeps its line while the clocks only tremble", () => {
    const alignment = new Alignment();
    const line = alignment.follow({ zero: 5, rate: 1 });
    for (let i = 0; i < 200; i++) {
      expect(alignment.follow({ zero: 5 + (i % 2 ? 0.02 : -0.02), rate: 1 })).toBe(line);
    }
  });

  it("goes after a clock that drifts before anybody could hear it", () => {
    const alignment = new Alignment();
    for (let frame = 0; frame < 60 * 600; frame++) {
      const zero = frame * 1e-5; // 0.6 ms a second: twelve times a bad clock
      const line = alignment.follow({ zero, rate: 1 });
      expect(Math.abs(line.zero - zero)).toBeLessThan(0.02);
    }
  });

  it("follows a seek, another rate and a new beginning at once", () => {
    const alignment = new Alignment();
    alignment.follow({ zero: 5, rate: 1 });
    expect(alignment.follow({ zero: 4.9, rate: 1 })).toEqual({ zero: 4.9, rate: 1 });
    expect(alignment.follow({ zero: 4.9, rate: 0.5 })).toEqual({ zero: 4.9, rate: 0.5 });
    alignment.forget();
    expect(alignment.follow({ zero: 4.905, rate: 0.5 })).toEqual({ zero: 4.905, rate: 0.5 });
  });
});
