import { expect, it } from "vitest";
import { pageAt } from "../../src/ui/page_address";

it.each(["/", "/index.html"])("lists the scenes at %s", (path) => {
  expect(pageAt(path)).toEqual({ kind: "list" });
});

it.each(["/view/studio-1f9c03ab", "/view/studio-1f9c03ab/"])("plays a scene at %s", (path) => {
  expect(pageAt(path)).toEqual({ kind: "view", scene: "studio-1f9c03ab" });
});

it.each(["/nothing", "/view", "/view/", "/view/a/b", `/view/${"a".repeat(65)}`, "/scenes/a"])(
  "has nothing at %s",
  (path) => {
    expect(pageAt(path)).toEqual({ kind: "unknown" });
  },
);
