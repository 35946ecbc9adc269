import { describe, expect, it } from "vitest";
import { parseViewParameters } from "../../src/ui/view_parameters";

describe("parseViewParameters", () => {
  it("has defaults that leave playing to the visitor's system, in the whole window", () => {
    expect(parseViewParameters("")).toEqual({
      time: null,
      camera: null,
      paused: null,
      size: null,
      exact: false,
      antialiased: null,
    });
  });

  it("reads every parameter", () => {
    const parsed = parseViewParameters("?t=0.5&camera=cam00&paused=1&width=512&height=384&exact=1&antialiased=1");
    const size = { width: 512, height: 384 };
    expect(parsed).toEqual({ time: 0.5, camera: "cam00", paused: true, size, exact: true, antialiased: true });
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
  ])("refuses %s and names the parameter", (search) => {
    expect(() => parseViewParameters(`?${search}`)).toThrow(search.includes("width") ? "width" : search.split("=")[0]);
  });
});
