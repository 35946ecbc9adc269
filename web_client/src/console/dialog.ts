/** Questions in a dialog over the page. */

import { element, setText } from "../dom/element";

interface Question {
  readonly title: string;
  readonly body: readonly (Node | string)[];
  /** The label of the confirming button, such as "Delete". */
  readonly action: string;
  /** Whether the action deletes something. */
  readonly danger?: boolean;
  /** The label of the other button. */
  readonly dismiss?: string;
  /** Perform the action; the dialog closes afterwards, and shows the reason of a failure. */
  run(): Promise<void>;
}

/**
 * Ask, and resolve when the dialog is closed: true if the action was performed. The focus returns to its earlier place.
 */
export function ask(question: Question): Promise<boolean> {
  const error = element("p", { class: "field-error", role: "alert" });
  const action = element("button", { class: question.danger ? "button danger" : "button primary" }, question.action);
  const dismiss = element("button", { type: "button", class: "button" }, question.dismiss ?? "Cancel");
  const title = element("h2", { id: "dialog-title" }, question.title);
  const form = element(
    "form",
    {},
    title,
    ...question.body,
    error,
    element("div", { class: "dialog-actions" }, dismiss, action),
  );
  const dialog = element("dialog", { class: "dialog", "aria-labelledby": "dialog-title" }, form);
  let done = false;
  dismiss.addEventListener("click", () => dialog.close());
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    action.disabled = true;
    setText(error, "");
    question.run().then(
      () => {
        done = true;
        dialog.close();
      },
      (reason: Error) => {
        action.disabled = false;
        setText(error, reason.message);
      },
    );
  });
  document.body.append(dialog);
  const before = document.activeElement;
  dialog.showModal();
  if (question.danger) dismiss.focus(); // a stray Enter deletes nothing
  return new Promise((resolve) => {
    dialog.addEventListener("close", () => {
      dialog.remove();
      if (before instanceof HTMLElement) before.focus();
      resolve(done);
    });
  });
}
