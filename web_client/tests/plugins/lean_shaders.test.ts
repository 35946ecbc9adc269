import { expect, it } from "vitest";
import { lean } from "../../plugins/lean_shaders.ts";

it("takes comments and indentation out, and keeps the lines that directives need", () => {
  const shader =
    "#version 300 es\n\nuniform vec2 size;   // pixels\nvoid main() {\n  // Half of it.\n  x = a / b;\n}\n";
  expect(lean(shader)).toBe("#version 300 es\nuniform vec2 size;\nvoid main() {\nx = a / b;\n}\n");
});
