/** The panel of a camera path: its key frames, playing along it, and its file. */

import { element, icon, setText } from "../dom/element";
import { formatTime } from "../dom/format";
import { CLOSE } from "../dom/icons";
import type { KeyFrame } from "./camera_path";

export interface PathPanelEvents {
  /** Set a key frame at the playhead. */
  add(): void;
  remove(key: KeyFrame): void;
  /** Show a key frame. */
  go(key: KeyFrame): void;
  /** Begin or end playing along the path. */
  follow(): void;
  save(): void;
  close(): void;
}

export interface PathState {
  readonly keys: readonly KeyFrame[];
  readonly following: boolean;
  /** Whether a key frame is at the playhead. */
  readonly here: boolean;
  /** The scene's start, seconds. */
  readonly start: number;
}

export class PathPanel {
  readonly node: HTMLElement;
  readonly #add: HTMLButtonElement;
  readonly #follow: HTMLButtonElement;
  readonly #save: HTMLButtonElement;
  readonly #list = element("ol", { class: "path-keys" });
  #listed: readonly KeyFrame[] | null = null;

  constructor(readonly events: PathPanelEvents) {
    const close = element("button", {
      type: "button",
      class: "round",
      title: "Close (N)",
      "aria-label": "Close",
      onclick: () => events.close(),
    });
    close.append(icon(CLOSE));
    this.#add = button("tool-main", () => events.add());
    this.#follow = button("path-button", () => events.follow(), "Play along");
    this.#save = button("path-button", () => events.save(), "Save for hgs render");
    this.node = element(
      "section",
      { class: "tool-panel path-panel", "aria-label": "Camera path" },
      element("header", { class: "tool-head" }, element("h2", {}, "Camera path"), close),
      this.#list,
      this.#add,
      element("div", { class: "path-buttons" }, this.#follow, this.#save),
    );
    this.node.addEventListener("keydown", (event) => {
      if (event.key !== "Escape") return;
      event.stopPropagation();
      events.close();
    });
  }

  show({ keys, following, here, start }: PathState): void {
    setText(this.#add, here ? "Set this key frame anew" : "Add a key frame here");
    this.#follow.setAttribute("aria-pressed", String(following));
    this.#follow.disabled = this.#save.disabled = keys.length === 0;
    if (this.#listed === keys) return;
    this.#listed = keys;
    this.#list.replaceChildren(...keys.map((key) => this.#row(key, formatTime(key.time - start))));
  }

  #row(key: KeyFrame, shown: string): HTMLElement {
    const remove = button("path-remove", () => {
      this.#add.focus(); // the focused button goes with its row
      this.events.remove(key);
    });
    remove.setAttribute("aria-label", `Remove the key frame at ${shown}`);
    remove.append(icon(CLOSE));
    const go = button("path-time", () => this.events.go(key), shown);
    go.setAttribute("aria-label", `To the key frame at ${shown}`);
    return element("li", {}, go, remove);
  }
}

const button = (kind: string, onclick: () => void, text = ""): HTMLButtonElement =>
  element("button", { type: "button", class: kind, onclick }, text);
