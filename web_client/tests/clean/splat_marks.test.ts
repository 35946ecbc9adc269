import { beforeEach, describe, expect, it } from "vitest";
import { DELETED, HIDDEN, SELECTED, SplatMarks, splatList } from "../../src/clean/splat_marks";

const select = (mark: number) => mark | SELECTED;
const remove = (mark: number) => (mark & ~SELECTED) | DELETED;

describe("marks", () => {
  let changed: (readonly string[])[];
  let marks: SplatMarks;

  beforeEach(() => {
    changed = [];
    marks = new SplatMarks(
      () => 10,
      (ids) => changed.push(ids),
    );
  });

  it("go back and forth step by step", () => {
    marks.change(new Map([["a", [1, 2, 3]]]), select);
    marks.change(marks.places(SELECTED), remove);
    expect([marks.count(SELECTED), marks.count(DELETED)]).toEqual([0, 3]);
    marks.undo();
    expect([marks.count(SELECTED), marks.count(DELETED)]).toEqual([3, 0]);
    marks.undo();
    expect([marks.count(SELECTED), marks.canUndo]).toEqual([0, false]);
    marks.redo();
    marks.redo();
    expect([...marks.places(DELETED)]).toEqual([["a", [1, 2, 3]]]);
    expect(marks.canRedo).toBe(false);
    expect(changed).toHaveLength(6);
  });

  it("forget what was undone once something else is done", () => {
    marks.change(new Map([["a", [1]]]), select);
    marks.undo();
    marks.change(new Map([["a", [2]]]), select);
    expect(marks.canRedo).toBe(false);
    expect(marks.places(SELECTED).get("a")).toEqual([2]);
  });

  it("make no step of a change without effect", () => {
    marks.change(new Map([["a", [1]]]), select);
    marks.change(new Map([["a", [1]]]), select);
    marks.undo();
    expect(marks.canUndo).toBe(false);
    expect(changed).toEqual([["a"], ["a"]]);
  });

  it("are counted without those with another mark", () => {
    marks.change(new Map([["a", [1, 2]]]), (mark) => mark | HIDDEN);
    marks.change(new Map([["a", [2]]]), (mark) => mark | DELETED);
    expect(marks.count(HIDDEN, DELETED)).toBe(1);
  });

  it("become the list of the deleted splats, in ranges", () => {
    marks.change(
      new Map([
        ["b", [0, 1, 2, 5, 9]],
        ["a", [7]],
      ]),
      remove,
    );
    marks.change(new Map([["a", [3]]]), select);
    const list = JSON.parse(splatList(marks.deleted()));
    expect(list).toEqual({
      format: "hgs-splats",
      version: 1,
      chunks: {
        b: [
          [0, 2],
          [5, 5],
          [9, 9],
        ],
        a: [[7, 7]],
      },
    });
  });
});
