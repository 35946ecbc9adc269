/** The panel of the crop tool: the kept part, the start of the edit, and the numbers of the box. */

import { element, icon, setText } from "../dom/element";
import { formatTime } from "../dom/format";
import { CLOSE } from "../dom/icons";
import { type CropBox, type CropWish, commandFor } from "./crop_box";

const SIDES = ["Width", "Height", "Depth"] as const;
const PLACES = ["X", "Y", "Z"] as const;

export interface CropPanelEvents {
  /** A number of the box was entered. */
  changed(box: CropBox): void;
  inverted(inverse: boolean): void;
  /** Return to the first box. */
  reset(): void;
  close(): void;
}

export class CropPanel {
  readonly node: HTMLElement;
  readonly #size = SIDES.map((name) => number(name));
  readonly #center = PLACES.map((name) => number(name));
  readonly #kept: readonly HTMLButtonElement[];
  readonly #command = element("code", { class: "crop-command", tabindex: 0 });
  readonly #trim = element("p", { class: "crop-note", hidden: true });
  readonly #numbers = element(
    "details",
    { class: "crop-numbers" },
    element("summary", {}, "Numbers and command"),
    element("div", { class: "crop-fields" }, ...this.#size.map(({ label }) => label)),
    element("div", { class: "crop-fields" }, ...this.#center.map(({ label }) => label)),
    this.#command,
  );
  #box: CropBox | null = null;

  /** @param applied the button that applies the crop, and its course. */
  constructor(events: CropPanelEvents, applied: readonly HTMLElement[]) {
    const close = element("button", {
      type: "button",
      class: "round",
      title: "Close (V)",
      "aria-label": "Close",
      onclick: () => events.close(),
    });
    close.append(icon(CLOSE));
    this.#kept = [false, true].map((inverse) =>
      element(
        "button",
        { type: "button", class: "tool-choice", onclick: () => events.inverted(inverse) },
        inverse ? "Keep outside" : "Keep inside",
      ),
    );
    const reset = element("button", { type: "button", class: "crop-reset", onclick: () => events.reset() }, "Reset");
    for (const [fields, name] of [
      [this.#size, "size"],
      [this.#center, "center"],
    ] as const) {
      fields.forEach(({ input }, axis) => {
        input.addEventListener("change", () => this.#typed(name, axis, input, events));
      });
    }
    this.node = element(
      "section",
      { class: "tool-panel crop-panel", "aria-label": "Crop" },
      element("header", { class: "tool-head crop-head" }, element("h2", {}, "Crop"), reset, close),
      element(
        "div",
        { class: "tool-choices crop-choices", role: "group", "aria-label": "What is kept" },
        ...this.#kept,
      ),
      this.#numbers,
      this.#trim,
      ...applied,
    );
    this.node.addEventListener("keydown", (event) => {
      if (event.key === "Escape") events.close();
      if (event.target instanceof HTMLInputElement || event.key === "Escape") event.stopPropagation();
    });
  }

  /** Whether the numbers are hidden. */
  set compact(compact: boolean) {
    this.#numbers.open = !compact;
  }

  /** Show a crop; `start` is the scene's, seconds. */
  show(wish: CropWish, start: number): void {
    this.#box = wish.box;
    const root = this.node.getRootNode() as ShadowRoot;
    for (const [fields, values] of [
      [this.#size, wish.box.size],
      [this.#center, wish.box.center],
    ] as const) {
      fields.forEach(({ input }, axis) => {
        if (root.activeElement !== input) input.value = fourDigits(values[axis]);
      });
    }
    this.#kept.forEach((button, i) => {
      button.setAttribute("aria-pressed", String(wish.inverse === (i === 1)));
    });
    this.#trim.hidden = wish.trim === null;
    if (wish.trim) {
      const [from, to] = wish.trim.map((time) => formatTime(time - start));
      setText(this.#trim, `Trimmed to the repeated part, ${from} to ${to}`);
    }
    setText(this.#command, commandFor(wish));
  }

  #typed(name: "size" | "center", axis: number, input: HTMLInputElement, events: CropPanelEvents): void {
    const box = this.#box;
    const value = input.valueAsNumber;
    if (!box) return;
    if (!Number.isFinite(value) || (name === "size" && value <= 0)) {
      input.value = fourDigits(box[name][axis]);
      return;
    }
    events.changed({ ...box, [name]: box[name].map((given, i) => (i === axis ? value : given)) });
  }
}

/** A number with four digits and no zeros at its end. */
const fourDigits = (value: number): string => String(Number(value.toPrecision(4)));

function number(name: string): { readonly label: HTMLElement; readonly input: HTMLInputElement } {
  const input = element("input", { type: "number", step: "any", inputmode: "decimal" });
  return { label: element("label", { class: "crop-field" }, element("span", {}, name), input), input };
}
