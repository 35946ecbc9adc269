import { expect, it } from "vitest";
import { parseViewParameters } from "../../src/console/view_parameters";
import { linkWithBookmarks, linkWithKeys, type SharedView, sharedLink } from "../../src/ui/shared_view";

const SHARED: SharedView = {
  time: 1.23456789,
  paused: true,
  camera: "cam 1&2",
  view: { position: [0.1234567, -2, 3e-9], target: [1, 2, 3], up: [0, -1, 0] },
  loopRange: [0.5, 1.5],
  bookmarks: [0.25, 1],
  subjectOnly: false,
};

it("is read back as it was shared, to seven digits", () => {
  const link = new URL(sharedLink("https://a.example/view/studio?antialiased=1&t=9&marks=4#part", SHARED));
  expect(link.pathname).toBe("/view/studio");
  expect(parseViewParameters(link.search)).toEqual({
    time: 1.234568,
    camera: "cam 1&2",
    paused: true,
    view: SHARED.view,
    loopRange: [0.5, 1.5],
    bookmarks: [0.25, 1],
    keys: [],
    antialiased: true,
    size: null,
    exact: false,
    subjectOnly: false,
  });
});

it("carries only what there is", () => {
  const bare = {
    ...SHARED,
    paused: false,
    camera: null,
    view: null,
    loopRange: null,
    bookmarks: [],
    subjectOnly: null,
  };
  expect(sharedLink("https://a.example/view/studio?paused=1&loop=1,2", bare)).toBe(
    "https://a.example/view/studio?t=1.234568",
  );
});

it("keeps bookmarks in an address and takes them out again, and leaves the rest", () => {
  const marked = linkWithBookmarks("https://a.example/view/studio?camera=side", [0.5, 1]);
  expect(marked).toBe("https://a.example/view/studio?camera=side&marks=0.5,1");
  expect(linkWithBookmarks(marked, [])).toBe("https://a.example/view/studio?camera=side");
});

it("keeps the key frames of a camera path in an address and takes them out again", () => {
  const numbers = [0.5, 1, 2, 3, 0, 0, 0.1234567, 50];
  const moving = linkWithKeys("https://a.example/view/studio?marks=1", numbers);
  expect(parseViewParameters(new URL(moving).search).keys).toEqual(numbers);
  expect(sharedLink(moving, SHARED)).toContain("&keys=0.5,1,2,3,0,0,0.1234567,50");
  expect(linkWithKeys(moving, [])).toBe("https://a.example/view/studio?marks=1");
});
