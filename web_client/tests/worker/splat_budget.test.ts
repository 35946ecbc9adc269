import { describe, expect, it } from "vitest";
import { DYNAMIC_BIT, STATICS_PER_ROW } from "../../src/renderer/layout";
import { levelOf, SplatBudget, utilityOf } from "../../src/worker/splat_budget";

const allowing = (rgb: number) => ({ position: 0, blur: 0, shape: 0, opacity: 0, rgb });

/** Statics in chunks of one row each, which allow these errors of colour. */
function budgetOf(errors: number[]): SplatBudget {
  const budget = new SplatBudget(errors.length);
  errors.forEach((rgb, row) => {
    budget.addStatics(row * STATICS_PER_ROW, STATICS_PER_ROW, allowing(rgb));
  });
  return budget;
}

/** What is left of all ids of so many rows, in an order of no meaning. */
function left(budget: SplatBudget, rows: number, most: number): { before: number[]; after: number[] } {
  const count = rows * STATICS_PER_ROW;
  const ids = Uint32Array.from({ length: count }, (_, i) => (1009 * i) % count);
  const before = Array.from(ids);
  return { before, after: Array.from(ids.subarray(0, budget.cut(ids, ids.length, most))) };
}

describe("SplatBudget", () => {
  it.each([1024, 1025, 1e9, Infinity])("leaves 1,024 splats as they are with a budget of %d", (most) => {
    const { before, after } = left(budgetOf([0.1, 0.01]), 2, most);
    expect(after).toEqual(before);
  });

  it("takes the chunks first whose errors must be smallest, and keeps the order of what it takes", () => {
    const { before, after } = left(budgetOf([0.08, 0.01, 0.02, 0.04]), 4, 1024);
    expect(after).toEqual(before.filter((id) => id >= 512 && id < 1536));
  });

  it("is never more than the budget, and less by next to nothing", () => {
    for (const most of [1, 100, 511, 700, 2047]) {
      const { after } = left(budgetOf([0.01, 0.01, 0.02, 0.04]), 4, most);
      expect(after.length).toBeLessThanOrEqual(most);
      expect(after.length).toBeGreaterThanOrEqual(most - 1024 / 64); // a 64th of the splats of a level
    }
  });

  it("spreads what it takes of splats that show equally much", () => {
    for (const share of [2, 3, 5]) {
      const { after } = left(budgetOf([0.01, 0.01, 0.01, 0.01]), 4, 2048 / share);
      const taken = after.sort((a, b) => a - b);
      expect(taken.length).toBeGreaterThan(1800 / share);
      const gaps = taken.map((id, i) => id - (taken[i - 1] ?? -1));
      expect(Math.max(...gaps)).toBeLessThanOrEqual(2 * share + 1);
    }
  });

  it("takes more where there is room for more, and nothing else instead", () => {
    const budget = budgetOf([0.01, 0.02, 0.04]);
    const small = left(budget, 3, 600).after;
    const large = new Set(left(budget, 3, 700).after);
    expect(small.every((id) => large.has(id))).toBe(true);
  });

  it("weighs what moves against what does not", () => {
    const budget = budgetOf([0.02]);
    budget.levels(3).set([0.01, 0.02, 0.04].map((rgb) => levelOf(utilityOf(allowing(rgb)))));
    const moving = [0, 1, 2].map((place) => (DYNAMIC_BIT | place) >>> 0);
    const all = [...moving, ...Array.from({ length: 512 }, (_, i) => i)];
    const ids = Uint32Array.from(all);
    expect(Array.from(ids.subarray(0, budget.cut(ids, 515, 514)))).toEqual(all.filter((id) => id !== moving[2]));
    const few = Uint32Array.from(all);
    expect(budget.cut(few, 515, 1)).toBe(1);
    expect(few[0]).toBe(moving[0]);
  });
});

describe("the utility of a chunk", () => {
  it("falls by two octaves where errors may be twice as large", () => {
    expect(utilityOf(allowing(0.01)) - utilityOf(allowing(0.02))).toBeCloseTo(2, 12);
  });

  it("has a level whatever errors are allowed", () => {
    expect([0, 1e-30, 1, 1e30].map((rgb) => levelOf(utilityOf(allowing(rgb))))).toEqual([255, 255, 96, 0]);
  });
});
