import { expect, it } from "vitest";
import { captureOf, newSceneOf, pageAt } from "../../src/console/page_address";

it.each(["/", "/index.html"])("lists the scenes at %s", (path) => {
  expect(pageAt(path)).toEqual({ kind: "list" });
});

it.each(["/view/studio-1f9c03ab", "/view/studio-1f9c03ab/"])("plays a scene at %s", (path) => {
  expect(pageAt(path)).toEqual({ kind: "view", scene: "studio-1f9c03ab" });
});

it.each(["/job/studio-1f9c03ab", "/job/studio-1f9c03ab/"])("shows a job at %s", (path) => {
  expect(pageAt(path)).toEqual({ kind: "job", job: "studio-1f9c03ab" });
});

it.each(["/new", "/new/"])("has the form for a new scene at %s", (path) => {
  expect(pageAt(path)).toEqual({ kind: "new" });
});

it.each([
  "/nothing",
  "/new/a",
  "/job",
  "/job/",
  "/job/a/b",
  "/view",
  "/view/",
  "/view/a/b",
  `/view/${"a".repeat(65)}`,
  "/scenes/a",
])("has nothing at %s", (path) => {
  expect(pageAt(path)).toEqual({ kind: "unknown" });
});

it("names a capture that is chosen in the form", () => {
  const address = newSceneOf("/srv/captures/a b&c=d/é");
  expect(pageAt(new URL(address, "http://x/").pathname)).toEqual({ kind: "new" });
  expect(captureOf(new URL(address, "http://x/").search)).toBe("/srv/captures/a b&c=d/é");
  expect(captureOf("")).toBe("");
});
