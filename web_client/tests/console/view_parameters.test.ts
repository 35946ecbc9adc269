import { describe, expect, it } from "vitest";
import { parseViewParameters } from "../../src/console/view_parameters";

describe("parseViewParameters", () => {
  it("has defaults that leave playing to the visitor's system, in the whole window", () => {
    expect(parseViewParameters("")).toEqual({
      time: null,
      camera: null,
      paused: null,
      size: null,
      exact: false,
      antialiased: null,
      splatBudget: undefined,
      subjectOnly: null,
      view: null,
      loopRange: null,
      bookmarks: [],
      keys: [],
    });
  });

  it("reads every parameter", () => {
    const parsed = parseViewParameters(
      "?t=0.5&camera=cam00&paused=1&width=512&height=384&exact=1&antialiased=1&splats=5e4&subject=0&view=1,2,3,4,5,6,0,-1,0&loop=0.5,1e1&marks=2,1&keys=1,2,3,4,5,6,7,50",
    );
    expect(parsed).toEqual({
      time: 0.5,
      camera: "cam00",
      paused: true,
      size: { width: 512, height: 384 },
      exact: true,
      antialiased: true,
      splatBudget: 50_000,
      subjectOnly: false,
      view: { position: [1, 2, 3], target: [4, 5, 6], up: [0, -1, 0] },
      loopRange: [0.5, 10],
      bookmarks: [2, 1],
      keys: [1, 2, 3, 4, 5, 6, 7, 50],
    });
  });

  it("tells a demand to play from none", () => {
    expect(parseViewParameters("?paused=0").paused).toBe(false);
  });

  it("tells antialiasing forbidden from antialiasing left to the scene", () => {
    expect(parseViewParameters("?antialiased=0").antialiased).toBe(false);
  });

  it.each([
    "t=soon",
    "t=",
    "t=Infinity",
    "width=1.5&height=2",
    "width=0&height=9",
    "width=9",
    "paused=yes",
    "antialiased=2",
    "splats=0.5",
    "subject=2",
    "splats=all",
    "view=1,2,3",
    "view=1,2,3,4,5,6,7,8,x",
    "loop=1",
    "loop=2,1",
    "marks=1,,2",
    "keys=1,2,3",
    "keys=2,0,0,0,1,1,1,50,1,0,0,0,1,1,1,50",
  ])("refuses %s and names the parameter", (search) => {
    expect(() => parseViewParameters(`?${search}`)).toThrow(search.includes("width") ? "width" : search.split("=")[0]);
  });
});
