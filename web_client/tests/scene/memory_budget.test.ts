import { describe, expect, it } from "vitest";
import { defaultBudget, dynamicRows } from "../../src/scene/memory_budget";
import { entry, manifest, slice } from "../scene";

const MB = 1 << 20;

it("allows a phone less than a desktop", () => {
  expect(defaultBudget({ userAgent: "Mozilla/5.0 (X11; Linux x86_64)", deviceMemory: 8 })).toBe(384 * MB);
  expect(defaultBudget({ userAgent: "Mozilla/5.0 (iPhone; CPU iPhone OS 19_0)" })).toBe(192 * MB);
  expect(defaultBudget({ deviceMemory: 4 })).toBe(192 * MB);
  expect(defaultBudget({})).toBe(384 * MB);
});

describe("dynamicRows", () => {
  /** Slices of one chunk of 1,000 rows each. */
  const long = manifest({
    slices: Array.from({ length: 50 }, (_, i) => ({
      ...slice(i, i + 1, []),
      chunks: [entry(`c${i}`, 256_000)],
    })),
  });

  it("makes room for all that moves if the budget has", () => {
    expect(dynamicRows(long, 0, 1e12, 1e6)).toBe(50_000);
  });

  it("stays within the budget, beside the statics", () => {
    const rows = dynamicRows(long, 0, 512 * MB, 1e6);
    expect(rows).toBeGreaterThan(5000);
    expect(rows * 256 * (128 + 72)).toBeLessThan(512 * MB); // texture, motion and lives of a splat
    const beside = dynamicRows(long, 4000, 512 * MB, 1e6);
    expect(beside).toBeLessThan(rows - 4000 * 0.6);
  });

  it("takes it from the index where pages of the manifest have not come", () => {
    const room = { all: { chunks: 50, splats: 50 * 256_000 }, most: { chunks: 2, splats: 512_000 } };
    const awaited = manifest({ slices: [{ ...slice(0, 50, []), chunks: [entry("page", 0)] }], room });
    expect(dynamicRows(awaited, 0, 1e12, 1e6)).toBe(50_050);
    expect(dynamicRows(awaited, 0, 1 * MB, 1e6)).toBe(2002);
  });

  it("has room for what one moment needs and the next, whatever the budget, and never more than a texture", () => {
    expect(dynamicRows(long, 0, 1 * MB, 1e6)).toBe(2000);
    expect(dynamicRows(long, 0, 1e12, 8192)).toBe(8192);
  });
});
