/** The panel for sending a folder: choose or drop it, watch its progress, pause and continue. */

import { element, setText } from "../dom/element";
import * as uploads from "../protocol/uploads";
import { type Chosen, fromDrop, fromPicker } from "../upload/chosen_files";
import { FileHasher } from "../upload/hash_file";
import { Transfer, type UploadRequests } from "../upload/transfer";
import { Speed } from "../upload/upload_progress";
import { TransferView } from "./transfer_view";
import "./upload.css";

const EVERY = 200; // milliseconds between two updates

const REQUESTS: UploadRequests = {
  uploads: async (signal) => (await uploads.listUploads(signal)).uploads,
  begin: uploads.beginUpload,
  files: uploads.listRemoteFiles,
  announce: uploads.announceFile,
  offset: uploads.remoteOffset,
  send: uploads.sendPiece,
  finish: uploads.finishUpload,
  wait: (seconds, signal) =>
    new Promise((resolve, reject) => {
      const timer = setTimeout(resolve, 1000 * seconds);
      signal.addEventListener("abort", () => {
        clearTimeout(timer);
        reject(signal.reason);
      });
    }),
};

export class UploadPanel {
  readonly node: HTMLElement;
  readonly #error = element("p", { class: "field-error", role: "alert" });
  readonly #body = element("div", { class: "upload-body" });
  readonly #choice: HTMLElement;
  #transfer: Transfer | null = null;

  /**
   * Create the panel.
   *
   * @param onCapture is called with the path of the sent capture
   */
  constructor(readonly onCapture: (path: string) => void) {
    this.#choice = this.#chooser();
    this.node = element(
      "section",
      { class: "upload", "aria-label": "Send a folder from this device" },
      this.#body,
      this.#error,
    );
    this.#body.append(this.#choice);
    const over = (event: DragEvent, inside: boolean) => {
      if (this.#transfer) return;
      event.preventDefault();
      this.node.classList.toggle("over", inside);
    };
    this.node.addEventListener("dragover", (event) => over(event, true));
    this.node.addEventListener("dragleave", (event) => over(event, false));
    this.node.addEventListener("drop", (event) => {
      over(event, false);
      if (this.#transfer || !event.dataTransfer) return;
      this.#take(fromDrop(event.dataTransfer.items));
    });
  }

  #chooser(): HTMLElement {
    const picker = (label: string, folder: boolean) => {
      const input = element("input", { type: "file", multiple: true, class: "unseen", webkitdirectory: folder });
      input.addEventListener("change", () => {
        if (input.files?.length) this.#take(Promise.resolve(fromPicker(input.files)));
        input.value = ""; // allows the same folder to be chosen again
      });
      return element("label", { class: "button" }, input, label);
    };
    const folders = "webkitdirectory" in HTMLInputElement.prototype;
    return element(
      "div",
      { class: "upload-choice" },
      element(
        "p",
        {},
        element("strong", {}, "Send one from this device"),
        element(
          "small",
          {},
          folders
            ? "Drop its folder here, or choose it: videos or pictures of every camera, and the poses if there are any."
            : "Choose the videos of all cameras, and the poses if there are any.",
        ),
      ),
      element(
        "div",
        { class: "actions" },
        folders ? picker("Choose a folder …", true) : null,
        picker("Choose files …", false),
      ),
    );
  }

  #take(choosing: Promise<Chosen>): void {
    setText(this.#error, "");
    choosing.then(
      (chosen) => {
        if (chosen.files.length === 0) setText(this.#error, "There are no files in it.");
        else this.#send(chosen);
      },
      () => setText(this.#error, "The folder cannot be read."),
    );
  }

  #send(chosen: Chosen): void {
    const hasher = new FileHasher();
    const speed = new Speed();
    const view = new TransferView(chosen.name);
    let drawn = 0;
    let timer: ReturnType<typeof setTimeout> | undefined;
    const draw = () => {
      clearTimeout(timer);
      timer = undefined;
      drawn = performance.now();
      if (transfer.state === "sending") speed.note(transfer.sent, drawn / 1000);
      else speed.reset();
      view.show(transfer, speed.perSecond());
    };
    let before = "";
    const transfer = new Transfer(
      chosen,
      REQUESTS,
      (file) => hasher.hash(file),
      () => {
        if (transfer.state !== before || performance.now() - drawn > EVERY) draw();
        else timer ??= setTimeout(draw, EVERY);
        before = transfer.state;
      },
    );
    this.#transfer = transfer;
    const end = () => {
      clearTimeout(timer);
      hasher.close();
      this.#transfer = null;
      this.#body.replaceChildren(this.#choice);
      this.#choice.querySelector("input")?.focus();
    };
    const run = () =>
      void transfer.run().then(() => {
        if (transfer.state !== "done" || !transfer.upload?.capture) return;
        end();
        this.onCapture(transfer.upload.capture);
      });
    view.pause.addEventListener("click", () => {
      if (transfer.state === "sending" || transfer.state === "waiting") transfer.pause();
      else run();
    });
    view.cancel.addEventListener("click", () => {
      transfer.pause();
      if (transfer.upload) void uploads.deleteUpload(transfer.upload.id).catch(() => {}); // otherwise it expires
      end();
    });
    this.#body.replaceChildren(view.node);
    run();
    view.pause.focus();
  }
}
