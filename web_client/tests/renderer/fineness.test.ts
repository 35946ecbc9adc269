import { beforeEach, describe, expect, it } from "vitest";
import type { Quality } from "../../src/renderer/fineness";
import { checkedSplats, LADDER, QualityControl } from "../../src/renderer/fineness";

let control: QualityControl;

beforeEach(() => {
  control = new QualityControl();
});

/** A device that needs `finest` ms for the finest picture, in proportion for others, draws `count` of them in motion. */
function move(finest: number, count: number): void {
  for (let i = 0; i < count; i++) control.measured(finest * LADDER[control.moving].cost, control.moving);
}

describe("auto", () => {
  it("begins with the finest, also on a slow device, until several pictures are known", () => {
    expect(control.moving).toBe(0);
    move(500, 3);
    expect(control.moving).toBe(0);
    move(500, 1);
    expect(control.moving).toBeGreaterThan(0);
  });

  it.each([20, 40, 80, 200])("holds 30 pictures a second where the finest takes %d ms", (finest) => {
    move(finest, 8);
    expect(finest * LADDER[control.moving].cost).toBeLessThanOrEqual(1000 / 30);
  });

  it("chooses no coarser than it must", () => {
    move(40, 8);
    expect(control.moving).toBe(1);
  });

  it("draws finest at rest on any device", () => {
    move(500, 8);
    expect(control.resting).toBe(0);
  });

  it("comes back to the finest when the device has become fast", () => {
    move(500, 8);
    move(10, 8);
    expect(control.moving).toBe(0);
  });

  it("does not swing where the finest takes about the budget", () => {
    move(34, 8);
    const rung = control.moving;
    move(32, 20);
    expect(control.moving).toBe(rung);
  });

  it("draws fewer splats where coarser pictures do not help, and all of them at rest", () => {
    move(250, 8);
    expect(control.splats(control.moving)).toBe(Infinity);
    move(500, 8);
    expect(control.splats(control.moving)).toBe(100_000);
    expect(control.splats(control.resting)).toBe(Infinity);
  });

  it("is not put off by one slow picture", () => {
    move(10, 8);
    control.measured(900, 0);
    expect(control.moving).toBe(0);
  });
});

describe("a quality that is chosen", () => {
  it.each<[Quality, number, boolean]>([
    ["high", 1, true],
    ["medium", 1, false],
    ["low", 0.5, false],
  ])("%s: %d of the resolution, half floats %s, on any device", (quality, scale, float) => {
    control.quality = quality;
    move(500, 8);
    expect(LADDER[control.moving]).toMatchObject({ scale, float });
    expect(control.resting).toBe(control.moving);
    expect(control.splats(control.moving)).toBe(quality === "low" ? 100_000 : Infinity);
  });
});

describe("a budget of splats", () => {
  it.each([1, 2.5, Infinity])("may be %d", (budget) => {
    expect(checkedSplats(budget)).toBe(budget);
  });

  it.each([0, -1, 0.5, Number.NaN])("may not be %d", (budget) => {
    expect(() => checkedSplats(budget)).toThrow(RangeError);
  });
});
