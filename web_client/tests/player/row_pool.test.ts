import { expect, it } from "vitest";
import { RowPool } from "../../src/scene/residency";

it("gives the lowest rows that are free, wherever they are", () => {
  const pool = new RowPool(6);
  expect(pool.take(2)).toEqual([0, 1]);
  const middle = pool.take(2);
  expect(pool.take(1)).toEqual([4]);
  pool.give(middle);
  expect(pool.free).toBe(3);
  expect(pool.take(3)).toEqual([2, 3, 5]);
});

it("refuses what it has not", () => {
  expect(() => new RowPool(1).take(2)).toThrow(RangeError);
});
