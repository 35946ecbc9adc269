/** Fields of a form with their labels and the place where their errors stand. */

import { element, setText } from "../dom/element";
import type { ApiError } from "../protocol/api";

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

/** The fields of the form, by the names that docs/rest.md gives them. */
export type Field = "capture" | "title" | "preset" | "hold_out";

const FIELDS: readonly Field[] = ["capture", "title", "preset", "hold_out"];

/** The form's field that an error is about, such as `hold_out` for `hold_out.3`; null where it has none for it. */
export function fieldOf(error: Pick<ApiError, "code" | "field">): Field | null {
  const name = error.field.split(".")[0];
  const found = FIELDS.find((field) => field === name);
  if (found) return found;
  return error.code === "capture-invalid" || error.code === "capture-outside" ? "capture" : null;
}

/** The server's line without what it begins with: beside the field, neither the status nor the name is needed. */
export function reasonOf(error: Pick<ApiError, "message" | "field">): string {
  const detail = error.message.replace(/^The server answered \d+: /, "");
  const prefix = `${error.field}: `;
  const reason = error.field !== "" && detail.startsWith(prefix) ? detail.slice(prefix.length) : detail;
  return reason.replace(/^[a-z](?=[a-z]* )/, (letter) => letter.toUpperCase()); // but no file's name
}
