/** The panel of the cleaning tool: the hand, the numbers of marked splats, and the start of the edit. */

import { element, icon, setText } from "../dom/element";
import { CLOSE } from "../dom/icons";

export type Hand = "look" | "brush" | "box";

export interface CleanState {
  readonly hand: Hand;
  readonly selected: number;
  readonly hidden: number;
  readonly deleted: number;
  readonly canUndo: boolean;
  readonly canRedo: boolean;
  /** Whether splats are being looked for. */
  readonly busy: boolean;
}

export interface CleanPanelEvents {
  hand(hand: Hand): void;
  /** Select or deselect at the middle of the picture. */
  middle(): void;
  deselect(): void;
  hide(): void;
  show(): void;
  remove(): void;
  undo(): void;
  redo(): void;
  save(): void;
  close(): void;
}

const HANDS: readonly (readonly [Hand, string])[] = [
  ["look", "Look"],
  ["brush", "Brush"],
  ["box", "Box"],
];

const button = (name: string, onclick: () => void, title?: string): HTMLButtonElement =>
  element("button", { type: "button", class: "clean-button", onclick, title }, name);

export class CleanPanel {
  readonly node: HTMLElement;
  readonly #hands: ReadonlyMap<Hand, HTMLButtonElement>;
  readonly #takes = element("input", { type: "checkbox" });
  readonly #through = element("input", { type: "checkbox" });
  readonly #size = element("input", { type: "range", min: 4, max: 160, value: 32, "aria-label": "Brush size" });
  readonly #sizeRow = element("label", { class: "clean-row" }, element("span", {}, "Brush size"), this.#size);
  readonly #counts = element("p", { class: "clean-counts", role: "status" });
  readonly #middle: HTMLButtonElement;
  readonly #deselect: HTMLButtonElement;
  readonly #hide: HTMLButtonElement;
  readonly #show: HTMLButtonElement;
  readonly #remove: HTMLButtonElement;
  readonly #undo: HTMLButtonElement;
  readonly #redo: HTMLButtonElement;
  readonly #save: HTMLButtonElement;

  /** @param applied the button that applies the edit, and its course. */
  constructor(events: CleanPanelEvents, applied: readonly HTMLElement[]) {
    const close = element("button", {
      type: "button",
      class: "round",
      title: "Close (E)",
      "aria-label": "Close",
      onclick: () => events.close(),
    });
    close.append(icon(CLOSE));
    this.#hands = new Map(
      HANDS.map(([hand, name]) => [
        hand,
        element("button", { type: "button", class: "tool-choice", onclick: () => events.hand(hand) }, name),
      ]),
    );
    this.#middle = button("At the middle", () => events.middle(), "Brush the middle of the picture");
    this.#deselect = button("Deselect", () => events.deselect());
    this.#hide = button("Hide", () => events.hide());
    this.#show = button("Show hidden", () => events.show());
    this.#remove = button("Delete", () => events.remove(), "Delete");
    this.#undo = button("Undo", () => events.undo(), "Ctrl + Z");
    this.#redo = button("Redo", () => events.redo(), "Ctrl + Shift + Z");
    this.#save = button("Save the list", () => events.save(), "For hgs edit --splats");
    this.node = element(
      "section",
      { class: "tool-panel clean-panel", "aria-label": "Clean" },
      element("header", { class: "tool-head" }, element("h2", {}, "Clean"), close),
      element(
        "div",
        { class: "tool-choices clean-choices", role: "group", "aria-label": "Hand" },
        ...this.#hands.values(),
      ),
      this.#sizeRow,
      element(
        "div",
        { class: "clean-checks" },
        element("label", {}, this.#takes, "Deselect instead"),
        element("label", {}, this.#through, "Also what is hidden behind"),
      ),
      this.#counts,
      element("div", { class: "clean-buttons" }, this.#middle, this.#deselect, this.#hide, this.#show),
      element("div", { class: "clean-buttons" }, this.#remove, this.#undo, this.#redo, this.#save),
      ...applied,
    );
  }

  /** Whether the hand takes splats from the selection. */
  get takes(): boolean {
    return this.#takes.checked;
  }

  /** Whether splats behind others are found, too. */
  get through(): boolean {
    return this.#through.checked;
  }

  /** Radius of the brush, CSS pixels. */
  get radius(): number {
    return this.#size.valueAsNumber;
  }

  show({ hand, selected, hidden, deleted, canUndo, canRedo, busy }: CleanState): void {
    for (const [name, choice] of this.#hands) choice.setAttribute("aria-pressed", String(name === hand));
    this.#sizeRow.hidden = hand === "box";
    const parts = [
      [selected, "selected"],
      [hidden, "hidden"],
      [deleted, "deleted"],
    ] as const;
    const text = parts.flatMap(([count, what]) => (count > 0 ? `${count.toLocaleString("en")} ${what}` : []));
    setText(this.#counts, busy ? "Looking …" : text.join(" · ") || "Nothing is marked");
    this.#deselect.disabled = this.#hide.disabled = this.#remove.disabled = selected === 0;
    this.#show.disabled = hidden === 0;
    this.#undo.disabled = !canUndo;
    this.#redo.disabled = !canRedo;
    this.#save.disabled = deleted === 0;
  }
}
