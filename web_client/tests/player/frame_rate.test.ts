import { describe, expect, it } from "vitest";
import { FrameRate } from "../../src/player/picture";

function drawn(...times: number[]): FrameRate {
  const frames = new FrameRate();
  for (const time of times) frames.count(time);
  return frames;
}

describe("FrameRate", () => {
  it("is the mean over the last second", () => {
    const times = Array.from({ length: 121 }, (_, i) => 20 * i);
    expect(drawn(...times).rate(2400)).toBeCloseTo(50);
  });

  it("tells rates below one", () => {
    const frames = drawn(0, 2500, 5000);
    expect(frames.rate(5000)).toBeCloseTo(0.4);
    expect(frames.rate(7000)).toBeCloseTo(0.4);
  });

  it("falls while a frame is late", () => {
    expect(drawn(0, 100, 200).rate(4200)).toBeCloseTo(0.25);
  });

  it("is 0 after a second of rest", () => {
    const frames = drawn(0, 20, 40);
    frames.rest();
    expect(frames.rate(60)).toBeCloseTo(50);
    expect(frames.rate(1100)).toBe(0);
  });

  it("does not count a rest as a slow frame", () => {
    const frames = drawn(0, 20);
    frames.rest();
    frames.count(9000);
    frames.count(9025);
    expect(frames.rate(9025)).toBeCloseTo(40);
  });

  it("counts frames drawn and dropped", () => {
    const frames = drawn(0, 50);
    frames.drop();
    expect([frames.drawn, frames.dropped]).toEqual([2, 1]);
  });
});
