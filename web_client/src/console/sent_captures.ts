/** The sent captures on the server: incomplete uploads, and finished ones. */

import { element } from "../dom/element";
import { formatBytes } from "../dom/format";
import { deleteUpload, listUploads, type Upload } from "../protocol/uploads";
import { ask } from "./dialog";

/** The list, collapsed; hidden while it is empty. `onDelete` is called after a capture was deleted. */
export class SentCaptures {
  readonly node = element("details", { class: "sent", hidden: true });

  constructor(readonly onDelete: () => void) {}

  async refresh(): Promise<void> {
    const uploads = await listUploads().then(
      ({ uploads }) => uploads,
      () => [], // the form works without
    );
    this.node.hidden = uploads.length === 0;
    this.node.replaceChildren(
      element("summary", {}, `Sent to this server: ${uploads.length}`),
      element("ul", {}, ...uploads.map((upload) => this.#row(upload))),
    );
  }

  #row(upload: Upload): HTMLElement {
    const name = upload.capture?.split("/").at(-1) ?? upload.name;
    const remove = element("button", { type: "button", class: "button", "aria-label": `Delete ${name} …` }, "Delete …");
    remove.addEventListener("click", () => void this.#delete(upload));
    return element(
      "li",
      {},
      element("span", {}, element("strong", {}, name), element("small", {}, describeUpload(upload, Date.now() / 1000))),
      remove,
    );
  }

  async #delete(upload: Upload): Promise<void> {
    const done = await ask({
      title: `Delete ${upload.name}?`,
      body: [
        element(
          "p",
          {},
          upload.capture
            ? "Its files are deleted from the server. Scenes made from it stay."
            : "The part already sent is lost.",
        ),
      ],
      action: "Delete",
      danger: true,
      run: () => deleteUpload(upload.id),
    });
    if (!done) return;
    await this.refresh();
    this.onDelete();
  }
}

/** "2.0 GB", "40 % of 2.0 GB has arrived; choose the same folder within 47 h". */
export function describeUpload({ capture, bytes, received, expires }: Upload, now: number): string {
  if (capture !== null) return formatBytes(bytes);
  const share = bytes > 0 ? Math.floor((100 * received) / bytes) : 100;
  const hours = Math.max(1, Math.floor(((expires ?? now) - now) / 3600));
  return `${share} % of ${formatBytes(bytes)} has arrived; choose the same folder within ${hours} h`;
}
