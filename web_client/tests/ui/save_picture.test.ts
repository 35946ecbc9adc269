import { expect, it } from "vitest";
import { pictureName } from "../../src/ui/save_picture";

it.each([
  ["studio", 1.2, "studio 0m01.20s.png"],
  ["Küche: a/b?", 61.005, "Küche a b 1m01.01s.png"],
  ["", 0, "scene 0m00.00s.png"],
])("names a picture of %j at %s s %j", (title, time, name) => {
  expect(pictureName(title, time)).toBe(name);
});
