/** The choice of the cameras that check a scene: a picture of each camera, and whether it is held out. */

import { element, setText } from "../dom/element";
import { type Capture, getCameraPictures } from "../protocol/api";

const FEW = 12; // cameras that are shown without being asked for
const CHOOSE = "Choose cameras";

export class CameraChoice {
  readonly #cameras = element("div", { class: "cameras" });
  readonly #summary = element("summary", {}, CHOOSE);
  readonly node = element("details", { class: "chosen-cameras" }, this.#summary, this.#cameras);
  #capture: Capture | undefined;
  #asking: AbortController | null = null; // null until the pictures are asked for

  constructor() {
    this.#cameras.addEventListener("change", () => setText(this.#summary, this.heldOut.join(", ") || CHOOSE));
    this.node.addEventListener("toggle", () => this.look());
  }

  /** The names of the chosen cameras; without any the server chooses. */
  get heldOut(): string[] {
    return [...this.#cameras.querySelectorAll<HTMLInputElement>("input:checked")].map(({ value }) => value);
  }

  /** Offer the cameras of a capture; many are folded away. */
  show(capture: Capture | undefined): void {
    this.#asking?.abort();
    this.#asking = null;
    this.#capture = capture;
    const names = capture?.cameras ?? [];
    setText(this.#summary, CHOOSE);
    this.#cameras.replaceChildren(
      ...names.map((name) =>
        element(
          "label",
          { class: "camera-card" },
          element("span", { class: "camera-picture" }),
          element("span", { class: "camera" }, element("input", { type: "checkbox", value: name }), name),
        ),
      ),
    );
    this.node.open = names.length <= FEW;
    this.look();
  }

  /** Ask for the pictures, once they can be seen. */
  look(): void {
    if (this.#asking || !this.#capture || !this.#cameras.checkVisibility()) return;
    this.#asking = new AbortController();
    const { signal } = this.#asking;
    getCameraPictures(this.#capture.capture, signal).then(
      (pictures) => {
        if (signal.aborted) return;
        for (const card of this.#cameras.children) {
          const picture = pictures[card.querySelector("input")?.value ?? ""];
          if (picture) card.firstElementChild?.replaceChildren(element("img", { src: picture, alt: "" }));
        }
      },
      () => {}, // names are enough
    );
  }
}
