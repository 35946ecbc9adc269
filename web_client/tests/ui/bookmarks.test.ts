import { expect, it } from "vitest";
import { neighbour, toggled } from "../../src/ui/bookmarks";

it("keeps moments in order", () => {
  expect(toggled([1, 3], 2)).toEqual([1, 2, 3]);
});

it("takes a mark away where one is already", () => {
  expect(toggled([1, 2], 1.004)).toEqual([2]);
});

it("finds the next mark and the one before, never the one it stands on", () => {
  const times = [1, 2, 3];
  expect([neighbour(times, 2, 1), neighbour(times, 2, -1)]).toEqual([3, 1]);
  expect([neighbour(times, 3, 1), neighbour(times, 1, -1)]).toEqual([null, null]);
});
