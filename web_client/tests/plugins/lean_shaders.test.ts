import { expect, it } from "vitest";
import { lean } from "../../plugins/lean_shaders.ts";

it("takes comments and spaces out, and keeps the lines that directives need", () => {
  const shader =
    "#version 300 es\n// The half of it.\n\nuniform vec2 size;   // pixels\n#ifdef HALF\nvoid half(float a);\n#endif\n" +
    "void main() {\n  // Half of it.\n  x = a / (b + 1.5) - 2;\n  return x;\n}\n";
  expect(lean(shader)).toBe(
    "#version 300 es\nuniform vec2 size;\n#ifdef HALF\nvoid half(float a);\n#endif\n" +
      "void main(){x=a/(b+1.5)-2;return x;}\n",
  );
});

it("makes no decrement of two signs", () => {
  expect(lean("x = a - -b + ++c;\n")).toBe("x=a - -b + ++c;\n");
});
