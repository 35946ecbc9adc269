import { describe, expect, it } from "vitest";
import { comfortableRate, EYE_QUALITIES, EyeQualityControl } from "../../src/xr/eye_quality";

/** Frames at 72 a second, of which every `late`th comes a frame late; returns how many changes there were. */
function run(control: EyeQualityControl, frames: number, late = 0, from = 0): number {
  let now = from;
  let changes = 0;
  for (let i = 1; i <= frames; i++) {
    now += (late > 0 && i % late === 0 ? 2 : 1) * (1000 / 72);
    if (control.frame(now)) changes++;
  }
  return changes;
}

describe("the quality of a headset's pictures", () => {
  it("stays the finest while frames come in time, or a few are late", () => {
    const control = new EyeQualityControl(72);
    expect(run(control, 720)).toBe(0);
    expect(run(control, 720, 10)).toBe(0);
    expect(control.quality).toBe(EYE_QUALITIES[0]);
  });

  it("goes down step by step while many frames are late, and no further than there are steps", () => {
    const control = new EyeQualityControl(72);
    expect(run(control, 72, 2)).toBe(1);
    expect(control.quality).toBe(EYE_QUALITIES[1]);
    run(control, 720, 2);
    expect(control.quality).toBe(EYE_QUALITIES.at(-1));
  });

  it("takes splats away only where a coarser picture was not enough", () => {
    const [splats, scales] = [EYE_QUALITIES.map((step) => step.splats), EYE_QUALITIES.map((step) => step.scale)];
    const first = splats.findIndex(Number.isFinite);
    expect(splats.slice(first)).toEqual([200_000, 100_000]);
    expect(new Set(scales.slice(first))).toEqual(new Set([Math.min(...scales)]));
  });

  it("comes back when frames are in time for a while", () => {
    const control = new EyeQualityControl(72);
    run(control, 72, 2);
    expect(run(control, 3 * 72)).toBe(0);
    expect(run(control, 72)).toBe(1);
    expect(control.quality).toBe(EYE_QUALITIES[0]);
  });

  it("waits twice as long before it tries again what did not work", () => {
    const control = new EyeQualityControl(72);
    run(control, 72, 2);
    run(control, 4 * 72);
    run(control, 72, 2);
    expect(run(control, 7 * 72)).toBe(0);
    expect(run(control, 72)).toBe(1);
  });

  it("does not take a headset that was put away for a slow one", () => {
    const control = new EyeQualityControl(72);
    run(control, 71, 6);
    control.interrupted();
    expect(run(control, 72, 0, 100_000)).toBe(0);
  });
});

describe("the frame rate", () => {
  it("is the lowest that is comfortable", () => {
    expect(comfortableRate([120, 90, 72, 60])).toBe(72);
    expect(comfortableRate([90, 120])).toBe(90);
  });

  it("is the highest where none is, and the headset's own where it names none", () => {
    expect(comfortableRate([30, 60])).toBe(60);
    expect(comfortableRate(undefined)).toBeNull();
  });
});
