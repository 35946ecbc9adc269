/** Fields of a form with their labels and the place where their errors stand. */

import { element, setText } from "../ui/element";

/** A group of controls with a legend, a hint, and a line for what is wrong. */
export class FormField {
  readonly node: HTMLElement;
  readonly #error: HTMLElement;

  /**
   * @param name of the field, unique on the page
   * @param legend what people read
   * @param controls what they use
   * @param hint a line that helps; "" for none
   */
  constructor(name: string, legend: string, controls: readonly HTMLElement[], hint = "") {
    this.#error = element("p", { class: "field-error", id: `${name}-error`, role: "alert" });
    this.node = element(
      "fieldset",
      { class: "form-field", name, "aria-describedby": this.#error.id },
      element("legend", {}, legend),
      hint === "" ? null : element("p", { class: "hint" }, hint),
      ...controls,
      this.#error,
    );
  }

  /** Say what is wrong; "" takes it back. */
  fault(reason: string): void {
    setText(this.#error, reason);
    this.node.classList.toggle("wrong", reason !== "");
    for (const input of this.node.querySelectorAll("input")) {
      if (reason === "") input.removeAttribute("aria-invalid");
      else input.setAttribute("aria-invalid", "true");
    }
  }

  focus(): void {
    const inputs = [...this.node.querySelectorAll<HTMLInputElement>("input:not(:disabled)")];
    (inputs.find((input) => input.checked) ?? inputs[0])?.focus();
  }
}

interface Choice {
  readonly value: string;
  readonly title: string;
  readonly note: string;
  /** Why it cannot be chosen; "" if it can. */
  readonly problem?: string;
}

/** Choices of which one is taken, each with a line that explains it. */
export function choices(name: string, all: readonly Choice[], chosen: string): HTMLElement {
  return element(
    "div",
    { class: "choices" },
    ...all.map(({ value, title, note, problem = "" }) =>
      element(
        "label",
        { class: "choice" },
        element("input", { type: "radio", name, value, checked: value === chosen, disabled: problem !== "" }),
        element("span", {}, element("strong", {}, title), element("small", {}, problem || note)),
      ),
    ),
  );
}

/** The value of the choice that is taken; "" for none. */
export const chosenIn = (node: HTMLElement): string =>
  node.querySelector<HTMLInputElement>("input[type=radio]:checked")?.value ?? "";
