/** Where people send a folder: choose or drop it, watch it go, pause it, and go on. */

import * as uploads from "../protocol/uploads";
import { element, setText } from "../ui/element";
import { formatBytes } from "../ui/format";
import { type Chosen, fromDrop, fromPicker } from "../upload/chosen_files";
import { FileHasher } from "../upload/hash_file";
import { Speed } from "../upload/speed";
import { type Line, type SentFile, Transfer, type TransferState } from "../upload/transfer";
import { describeTransfer } from "../upload/upload_words";
import "./upload.css";

const MOST_ROWS = 100; // files that are listed
const EVERY = 200; // milliseconds between two drawings

const STATE_WORDS: Readonly<Record<SentFile["state"], string>> = {
  waiting: "waits",
  reading: "is read",
  sending: "",
  there: "there",
};

/** Of a failure, the whole words are said. */
const SAID: Readonly<Record<TransferState, string>> = {
  sending: "Sending",
  paused: "Paused",
  waiting: "Waiting for the server",
  finishing: "All is sent",
  done: "Sent",
  failed: "",
};

const LINE: Line = {
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

  /** @param onCapture is called with the path of the capture that was sent */
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
        input.value = ""; // so that the same folder can be chosen again
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
      LINE,
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
      if (transfer.upload) void uploads.deleteUpload(transfer.upload.id).catch(() => {}); // else it expires
      end();
    });
    this.#body.replaceChildren(view.node);
    run();
    view.pause.focus();
  }
}

/** One transfer on the page. */
class TransferView {
  readonly node: HTMLElement;
  readonly pause = element("button", { type: "button", class: "button" }, "Pause");
  readonly cancel = element("button", { type: "button", class: "button quiet" }, "Cancel");
  readonly #bar = element("progress", { max: 1, value: 0, "aria-label": "Sent" });
  readonly #words = element("p", { class: "upload-words" });
  readonly #told = element("p", { class: "unseen", role: "status" }); // what is read out: not every byte
  readonly #summary = element("summary", {}, "Files");
  readonly #rows = element("ul", { class: "upload-files" });

  constructor(name: string) {
    this.node = element(
      "div",
      { class: "transfer" },
      element("strong", {}, name),
      this.#bar,
      this.#words,
      this.#told,
      element("p", { class: "hint" }, "If this page is closed, choose the same folder again: it goes on where it was."),
      element("div", { class: "actions" }, this.pause, this.cancel),
      element("details", {}, this.#summary, this.#rows),
    );
  }

  show(transfer: Transfer, perSecond: number | null): void {
    const { state, files, sent, total } = transfer;
    this.#bar.value = total > 0 ? sent / total : 1;
    const words = describeTransfer(transfer, perSecond);
    setText(this.#words, words);
    setText(this.#told, SAID[state] || words);
    this.#words.classList.toggle("wrong", state === "failed");
    setText(this.pause, state === "failed" ? "Try again" : state === "paused" ? "Go on" : "Pause");
    this.pause.disabled = state === "finishing" || state === "done";
    const there = files.filter((file) => file.state === "there").length;
    setText(this.#summary, `${there.toLocaleString("en")} of ${files.length.toLocaleString("en")} files`);
    // those under way first, then those to come
    const rank = { sending: 0, reading: 1, waiting: 2, there: 3 };
    const shown = [...files].sort((a, b) => rank[a.state] - rank[b.state]).slice(0, MOST_ROWS);
    shown.forEach((file, place) => {
      const row = this.#rows.children[place] ?? this.#rows.appendChild(fileRow());
      showFile(row, file);
    });
  }
}

const fileRow = (): HTMLElement =>
  element(
    "li",
    {},
    element("span"),
    element("small"),
    element("progress", { max: 1, value: 0, "aria-hidden": "true" }),
  );

function showFile(row: Element, { path, size, sent, state }: SentFile): void {
  const [name, words, bar] = row.children;
  setText(name, path);
  setText(words, STATE_WORDS[state] || `${formatBytes(sent)} of ${formatBytes(size)}`);
  (bar as HTMLProgressElement).value = state === "there" ? 1 : size > 0 ? sent / size : 0;
}
