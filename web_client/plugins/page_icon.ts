import { readFileSync } from "node:fs";
import type { Plugin } from "vite";

/** Put the pages' icon beside the player, for the page that publishing writes around it. */
export function pageIcon(): Plugin {
  return {
    name: "page-icon",
    apply: "build",
    generateBundle() {
      this.emitFile({ type: "asset", fileName: "icon.svg", source: readFileSync("public/icon.svg", "utf-8") });
    },
  };
}
