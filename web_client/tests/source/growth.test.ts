import { describe, expect, it } from "vitest";
import { continues, grown, type ManifestDocument } from "../../src/source/growth";

const slice = (id: string) => ({ chunks: [{ id }] });
const first: ManifestDocument = {
  live: 1,
  end: 1,
  static: [{ id: "s" }],
  segments: [{ start: 0 }],
  slices: [slice("a")],
};
const last: ManifestDocument = {
  end: 2,
  static: [{ id: "s" }],
  segments: [{ start: 0 }, { start: 1 }],
  slices: [slice("a"), slice("b")],
};

describe("grown", () => {
  it("appends segments and slices, and takes the other fields, of which live goes where there is none", () => {
    const growth = { end: 2, segments: [{ start: 1 }], slices: [slice("b")] } as unknown as ManifestDocument;
    expect(grown(first, growth)).toEqual(last);
    expect(grown(first, { ...growth, live: 2 })).toEqual({ ...last, live: 2 });
  });

  it("refuses what names no segments", () => {
    expect(grown(first, { slices: [] } as unknown as ManifestDocument)).toBeNull();
  });
});

describe("continues", () => {
  it("is true of a later version alone", () => {
    expect(continues(last, first)).toBe(true);
    expect(continues({ ...last, live: 2 }, first)).toBe(true);
    expect(continues({ ...last, live: 1 }, first)).toBe(false);
    expect(continues(first, first)).toBe(false);
    expect(continues(first, last)).toBe(false);
  });

  it("is false where anything that was there is another", () => {
    expect(continues({ ...last, end: 0.5 }, first)).toBe(false);
    expect(continues({ ...last, static: [{ id: "t" }] }, first)).toBe(false);
    expect(continues({ ...last, static: [{ id: "s" }, { id: "t" }] }, first)).toBe(false);
    expect(continues({ ...last, slices: [slice("b"), slice("a")] }, first)).toBe(false);
    expect(continues({ ...last, segments: [{ start: 1 }] }, first)).toBe(false);
  });
});
