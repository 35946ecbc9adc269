import { expect, it } from "vitest";
import { bufferedGradient } from "../../src/ui/timeline";

it("draws every buffered range as a bar of its own", () => {
  const gradient = bufferedGradient(
    [
      [1, 2],
      [4, 5],
    ],
    1,
    5,
  );
  expect(gradient).toContain("var(--buffered) 0.00%, var(--buffered) 25.00%, transparent 25.00%, transparent 75.00%");
  expect(gradient).toContain("var(--buffered) 100.00%");
});

it("draws nothing where nothing is buffered", () => {
  expect(bufferedGradient([], 0, 1)).toBe("none");
});
