/** The last picture of a job. */

import { element } from "../dom/element";
import { pictureUrl } from "../protocol/api";

export class JobPicture {
  readonly #caption = element("figcaption", { class: "hint" }, "The first picture appears once training starts.");
  readonly node = element("figure", { class: "job-picture" }, this.#caption);
  #version: string | null = null;
  #shown: HTMLImageElement | null = null;

  constructor(readonly job: string) {}

  /** Show the picture of a version; the one before stays until it has come. */
  show(version: string | null): void {
    if (version === null || version === this.#version) return;
    this.#version = version;
    const picture = element("img", { src: pictureUrl(this.job, version), alt: "The scene as it is now" });
    picture.decode().then(
      () => {
        if (version !== this.#version) return;
        if (this.#shown) this.#shown.replaceWith(picture);
        else this.node.replaceChildren(picture);
        this.#shown = picture;
      },
      () => {
        if (version === this.#version) this.#version = null; // it was replaced meanwhile: look again
      },
    );
  }
}
