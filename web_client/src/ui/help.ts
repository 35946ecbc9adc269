/** The help: a dialog with all keys and gestures. The browser keeps the focus inside, and Esc closes it. */

import { element, icon } from "../dom/element";
import { CLOSE } from "../dom/icons";
import type { KeyGroup } from "./key_bindings";

type Row = readonly [string, string];

/** Keys of flying, by their positions, see `FlyMode`. */
export const FLYING: readonly Row[] = [
  ["W, S", "Forward and back"],
  ["A, D", "Left and right"],
  ["E, Q", "Up and down"],
  ["Shift", "Three times as fast"],
  ["Drag", "Look around"],
];

export const GESTURES: readonly Row[] = [
  ["Click or tap", "Play or pause"],
  ["Double click or tap", "Look at this point"],
  ["Drag", "Turn around the middle of the picture"],
  ["Shift + drag, right drag", "Move across the picture"],
  ["Two fingers", "Move closer, away or across"],
  ["Wheel", "Move closer or away"],
];

/** The display of keys: "K", "Space, K". */
export const shownKeys = ({ keys, shown }: { readonly keys: readonly string[]; readonly shown?: string }): string =>
  shown ?? keys.map((key) => (key.length === 1 ? key.toUpperCase() : key)).join(", ");

export class Help {
  readonly #groups = element("div", { class: "help-groups" });
  readonly #close = element("button", { type: "button", class: "round", title: "Close (Esc)", "aria-label": "Close" });
  readonly node = element(
    "dialog",
    { class: "help", "aria-label": "Keys and gestures" },
    element("div", { class: "help-head" }, element("h2", {}, "Keys and gestures"), this.#close),
    this.#groups,
  );

  constructor() {
    this.#close.append(icon(CLOSE));
    this.#close.addEventListener("click", () => this.node.close());
    // A click beside the box hits the dialog itself.
    this.node.addEventListener("click", (event) => {
      if (event.target === this.node) this.node.close();
    });
    this.node.addEventListener("keydown", (event) => {
      if (event.key !== "?") return;
      event.preventDefault();
      this.node.close();
    });
  }

  get open(): boolean {
    return this.node.open;
  }

  /** Show the keys for the present scene. */
  show(groups: readonly KeyGroup[]): void {
    const keys = groups.map(({ name, bindings }) =>
      table(
        name,
        bindings.map((binding) => [shownKeys(binding), binding.does]),
      ),
    );
    const gestures = table("Mouse and fingers", GESTURES);
    const flying = table("While flying", FLYING);
    const fingers = matchMedia("(hover: none)").matches; // probably without a keyboard
    this.#groups.replaceChildren(...(fingers ? [gestures, ...keys, flying] : [...keys, flying, gestures]));
    this.node.showModal();
  }
}

function table(name: string, rows: readonly Row[]): HTMLElement {
  const keys = (text: string) => text.split(", ").flatMap((key, i) => [i > 0 ? " " : null, element("kbd", {}, key)]);
  return element(
    "section",
    {},
    element("h3", {}, name),
    element(
      "dl",
      {},
      ...rows.map(([shown, does]) => element("div", {}, element("dt", {}, ...keys(shown)), element("dd", {}, does))),
    ),
  );
}
