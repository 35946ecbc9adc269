/** "Apply" of the tools that edit a scene: its button, and the course of the job that it starts. */

import { element, setText } from "./element";

/** A requested edit, in one line; `link` leads to its job or its scene. */
export interface EditCourse {
  readonly text: string;
  readonly link?: { readonly name: string; readonly address: string };
  /** Whether it goes on. */
  readonly busy: boolean;
}

/** Start the edit of a document (docs/editing.md); `show` is called with its course. */
export type StartEdit = (document: string, show: (course: EditCourse) => void) => void;

export class EditApplication {
  readonly #button = element("button", { type: "button", class: "tool-main" }, "Apply");
  readonly #line = element("p", { class: "tool-course", role: "status", hidden: true });
  readonly nodes: readonly HTMLElement[] = [this.#button, this.#line];
  #ready = false;
  #course: EditCourse | null = null;
  #scene = {}; // an object for each scene

  /**
   * Create the button.
   *
   * @param document the edit as it is now
   */
  constructor(start: StartEdit, document: () => string) {
    this.#button.addEventListener("click", () => {
      const scene = this.#scene;
      start(document(), (course) => {
        if (this.#scene === scene) this.#show(course);
      });
    });
    this.#update();
  }

  /** Whether there is anything to apply. */
  set ready(ready: boolean) {
    this.#ready = ready;
    this.#update();
  }

  /** The edit has changed: the course of an earlier one is shown while it goes on. */
  changed(): void {
    if (!this.#course?.busy) this.#show(null);
  }

  /** Show a line in place of the course. */
  say(text: string): void {
    this.#show({ text, busy: false });
  }

  /** Forget the edit: another scene has come. */
  forget(): void {
    this.#scene = {};
    this.#show(null);
  }

  #show(course: EditCourse | null): void {
    this.#course = course;
    this.#update();
    this.#line.hidden = course === null;
    if (!course) return;
    const { text, link } = course;
    const shown = this.#line.querySelector("a");
    if (shown?.getAttribute("href") !== link?.address)
      this.#line.replaceChildren(
        element("span", {}),
        ...(link ? [" ", element("a", { href: link.address }, link.name)] : []),
      );
    const words = this.#line.querySelector("span") ?? this.#line.appendChild(element("span", {}));
    setText(words, text);
  }

  #update(): void {
    this.#button.disabled = !this.#ready || this.#course?.busy === true;
  }
}
