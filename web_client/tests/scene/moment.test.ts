import { describe, expect, it } from "vitest";
import { drawnTime, momentOf, nextMoment, normalised } from "../../src/scene/moment";
import type { Playback } from "../../src/scene/playback";
import { manifest, slice } from "../scene";

const scene = manifest({
  end: 4,
  segments: [
    { start: 0, end: 2 },
    { start: 2, end: 4 },
  ],
  slices: [slice(0, 1, ["a"]), slice(1, 2, ["b"]), slice(2, 4, ["c"], [], 1)],
});

it("is cut to the segment of its time", () => {
  expect(momentOf(scene, 1.9, 1.8, 2.1)).toEqual({ time: 1.9, from: 1.8, until: 2 });
  expect(momentOf(scene, 2.05, 1.95, 2.2)).toEqual({ time: 2.05, from: 2, until: 2.2 });
  expect(momentOf(scene, 1)).toEqual({ time: 1, from: 1, until: 1 });
});

it("is drawn at the playhead's time, as far as the order goes", () => {
  const moment = { time: 1, from: 0.9, until: 1.1 };
  expect(drawnTime(moment, 1.03)).toBe(1.03);
  expect(drawnTime(moment, 0.95)).toBe(0.95);
  expect(drawnTime(moment, 1.2)).toBe(1.1);
  expect(drawnTime(moment, 0.8)).toBe(0.9);
});

it("is drawn exactly as it was ordered where no eye sees the difference", () => {
  expect(drawnTime({ time: 1, from: 0.9, until: 1.1 }, 1.0015)).toBe(1);
});

it("is drawn as it was ordered when the playhead jumps", () => {
  expect(drawnTime({ time: 0.01, from: 0.01, until: 0.07 }, 3.99)).toBe(0.01); // the order for after the loop
  expect(drawnTime({ time: 3, from: 3, until: 3 }, 1)).toBe(3); // the order from before a seek
});

it("is given to the renderer in the time of its segment, also at the segment's end", () => {
  const moment = momentOf(scene, 1.9, 1.9, 2);
  expect(normalised(scene, moment, 1.5)).toBe(0.75);
  expect(normalised(scene, moment, 2)).toBe(1);
  expect(normalised(scene, momentOf(scene, 2), 2)).toBe(0);
  expect(normalised(manifest(), momentOf(manifest(), 1), 1)).toBe(0);
});

describe("nextMoment", () => {
  /** A playhead at `time`; what can be shown begins before `until`. */
  const playback = (time: number, moving: boolean, until = 4) =>
    ({
      clock: { time, rate: 1, after: (lead: number) => time + lead },
      moving,
      buffer: { manifest: scene, playable: (at: number) => at < until },
    }) as unknown as Playback;
  const shown = { time: 0.5, from: 0.4, until: 0.6 };

  it("is the very moment while the playhead rests", () => {
    expect(nextMoment(playback(1, false), shown, 0.1)).toEqual({ time: 1, from: 1, until: 1 });
  });

  it("is the one at which the order will be shown while it moves, and those about it", () => {
    expect(nextMoment(playback(1, true), shown, 0.25)).toEqual({ time: 1.25, from: 1, until: 1.75 });
    expect(nextMoment(playback(1, true), shown, 0)).toEqual({ time: 1, from: 1, until: 1.05 });
  });

  it("is the playhead's where what comes then cannot be shown yet", () => {
    expect(nextMoment(playback(1, true, 1.1), shown, 0.25)).toEqual({ time: 1, from: 1, until: 1.5 });
  });

  it("is what was shown last where the playhead lacks its base, and none if nothing was", () => {
    expect(nextMoment(playback(1, true, 0.9), shown, 0.1)).toEqual({ time: 0.5, from: 0.5, until: 0.5 });
    expect(nextMoment(playback(1, true, 0.9), null, 0.1)).toBeNull();
  });
});
