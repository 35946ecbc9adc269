import { afterEach, expect, it, vi } from "vitest";
import { retryDelay } from "../../src/source/retry_delay";

afterEach(() => vi.restoreAllMocks());

it("is anywhere in a span that doubles up to eight seconds", () => {
  const random = vi.spyOn(Math, "random").mockReturnValue(0.5);
  expect([0, 1, 2, 3, 4, 5, 50].map(retryDelay)).toEqual([250, 500, 1000, 2000, 4000, 4000, 4000]);
  random.mockReturnValue(0);
  expect(retryDelay(3)).toBe(0);
});
