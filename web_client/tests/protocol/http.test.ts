import { afterEach, expect, it } from "vitest";
import { pageAt } from "../../src/console/page_address";
import { thumbnailUrl } from "../../src/protocol/api";
import { beginSiteAt, pathInSite, siteUrl } from "../../src/protocol/http";

afterEach(() => beginSiteAt("/"));

it("is at the root of the host unless it is said where", () => {
  expect(siteUrl("v1/scenes")).toBe("/v1/scenes");
  expect(pathInSite("/view/studio")).toBe("/view/studio");
});

it.each(["/hgs/", "/a/b/c/", "/my%20scenes/", "/view/x/"])("has its pages and its API below %s", (root) => {
  beginSiteAt(root);
  expect(siteUrl("v1/scenes")).toBe(`${root}v1/scenes`);
  expect(thumbnailUrl("studio")).toBe(`${root}v1/scenes/studio/thumbnail`);
  expect(pageAt(pathInSite(root))).toEqual({ kind: "list" });
  expect(pageAt(pathInSite(`${root}view/studio`))).toEqual({ kind: "view", scene: "studio" });
  expect(pageAt(pathInSite(`${root}job/a/`))).toEqual({ kind: "job", job: "a" });
});
