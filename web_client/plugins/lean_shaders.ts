import type { Plugin } from "vite";

/** Take comments and indentation out of shaders, which no minifier of scripts does. */
export function leanShaders(): Plugin {
  return {
    name: "lean-shaders",
    apply: "build",
    enforce: "pre",
    transform(code, id) {
      if (!/\/shaders\.ts$/.test(id)) return null;
      return code.replace(/`#version[^`]*`/g, lean);
    },
  };
}

/** GLSL without what only people read. */
export function lean(glsl: string): string {
  return glsl.replace(/[ \t]*\/\/[^\n]*/g, "").replace(/\n\s+/g, "\n");
}
