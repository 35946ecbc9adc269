import { expect, it } from "vitest";
import { backingSize } from "../../src/player/backing_size";

it("takes the browser's rounding of a fractional ratio", () => {
  const css = { width: 401, height: 301 };
  expect(backingSize(css, { width: 601, height: 452 }, 1.5)).toEqual({ width: 601, height: 452 });
});

it("does not trust device pixels of another ratio", () => {
  const css = { width: 600, height: 400 };
  expect(backingSize(css, { width: 600, height: 400 }, 2)).toEqual({ width: 1200, height: 800 });
});

it("multiplies where the browser tells no device pixels, and stops at two per CSS pixel", () => {
  const css = { width: 390, height: 700 };
  expect(backingSize(css, null, 1)).toEqual(css);
  expect(backingSize(css, { width: 1170, height: 2100 }, 3)).toEqual({ width: 780, height: 1400 });
});

it("has at least one pixel", () => {
  expect(backingSize({ width: 0, height: 0 }, { width: 0, height: 0 }, 1)).toEqual({ width: 1, height: 1 });
});
