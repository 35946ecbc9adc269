import { expect, it, vi } from "vitest";
import { Bookmarks } from "../../src/ui/bookmarks";

it("keeps moments in order, and tells every change", () => {
  const changed = vi.fn();
  const bookmarks = new Bookmarks([3, 1], changed);
  expect(bookmarks.toggle(2)).toBe(true);
  expect(bookmarks.times).toEqual([1, 2, 3]);
  expect(changed).toHaveBeenCalledOnce();
});

it("takes a mark away where one is already", () => {
  const bookmarks = new Bookmarks([1, 2], () => {});
  expect(bookmarks.toggle(1.004)).toBe(false);
  expect(bookmarks.times).toEqual([2]);
});

it("finds the next mark and the one before, never the one it stands on", () => {
  const bookmarks = new Bookmarks([1, 2, 3], () => {});
  expect([bookmarks.neighbour(2, 1), bookmarks.neighbour(2, -1)]).toEqual([3, 1]);
  expect([bookmarks.neighbour(3, 1), bookmarks.neighbour(1, -1)]).toEqual([null, null]);
});
