import { readFileSync } from "node:fs";
import type { Plugin } from "vite";

/** Take comments and spaces out of shaders, which no minifier of scripts does. */
export function leanShaders(): Plugin {
  return {
    name: "lean-shaders",
    apply: "build",
    enforce: "pre",
    load(id) {
      const file = /(.*\.(vert|frag))\?raw$/.exec(id)?.[1];
      return file ? `export default ${JSON.stringify(lean(readFileSync(file, "utf-8")))}` : null;
    },
  };
}

/** GLSL without comments and needless white space; directives keep lines of their own. */
export function lean(glsl: string): string {
  return glsl
    .split(/^(#.*\n)/m)
    .map((part) => (part.startsWith("#") ? part : leanStatements(part)))
    .join("");
}

function leanStatements(glsl: string): string {
  return glsl
    .replace(/\/\/.*/g, "")
    .replace(/\s+/g, " ")
    .replace(/^ /, "")
    .replace(/ ?([^\w +-]) ?/g, "$1")
    .replace(/(?<=[\w)\]]) ?([+-]) ?(?=[\w(.])/g, "$1") // not in a - -b, which would become a decrement
    .replace(/.$/, "$&\n");
}
