/** Fields of a form with their labels and error messages. */

import { element, setText } from "../dom/element";
import type { ApiError } from "../protocol/api";

/** A group of controls with a legend, a hint, and an error message. */
export class FormField {
  readonly node: HTMLElement;
  readonly #error: HTMLElement;

  /**
   * Create a field.
   *
   * @param name of the field, unique on the page
   * @param legend its visible name
   * @param controls its inputs
   * @param hint a line of help; "" for none
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

  /** Show an error; "" removes it. */
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
  /** The reason for which it is disabled; "" if it is not. */
  readonly problem?: string;
  /** The address of a small picture. */
  readonly picture?: string | null;
}

/** A group of exclusive choices, each with an explanation. */
export function choices(name: string, all: readonly Choice[], chosen: string): HTMLElement {
  return element(
    "div",
    { class: "choices" },
    ...all.map(({ value, title, note, problem = "", picture }) =>
      element(
        "label",
        { class: "choice" },
        element("input", { type: "radio", name, value, checked: value === chosen, disabled: problem !== "" }),
        element("span", {}, element("strong", {}, title), element("small", {}, problem || note)),
        picture ? element("img", { src: picture, alt: "" }) : null,
      ),
    ),
  );
}

/** The value of the checked choice; "" for none. */
export const chosenIn = (node: HTMLElement): string =>
  node.querySelector<HTMLInputElement>("input[type=radio]:checked")?.value ?? "";

/** The fields of the form, by their names in docs/rest.md. */
export type Field = "capture" | "title" | "preset" | "hold_out";

const FIELDS: readonly Field[] = ["capture", "title", "preset", "hold_out"];

/** The form's field of an error, such as `hold_out` for `hold_out.3`; null if there is none. */
export function fieldOf(error: Pick<ApiError, "code" | "field">): Field | null {
  const name = error.field.split(".")[0];
  const found = FIELDS.find((field) => field === name);
  if (found) return found;
  return error.code === "capture-invalid" || error.code === "capture-outside" ? "capture" : null;
}

/** The server's message without its prefix: next to the field, status and name are not needed. */
export function reasonOf(error: Pick<ApiError, "message" | "field">): string {
  const detail = error.message.replace(/^The server answered \d+: /, "");
  const prefix = `${error.field}: `;
  const reason = error.field !== "" && detail.startsWith(prefix) ? detail.slice(prefix.length) : detail;
  return reason.replace(/^[a-z](?=[a-z]* )/, (letter) => letter.toUpperCase()); // unless it is a file's name
}
