/** The view of an upload: its progress, its files, and its actions. */

import { element, setText } from "../dom/element";
import { formatBytes } from "../dom/format";
import type { SentFile, Transfer, TransferState } from "../upload/transfer";
import { describeTransfer } from "../upload/upload_progress";

const MOST_ROWS = 100; // listed files

const STATE_WORDS: Readonly<Record<SentFile["state"], string>> = {
  waiting: "waits",
  reading: "is read",
  sending: "",
  there: "there",
};

/** Labels of states; a failure has a whole sentence. */
const LABELS: Readonly<Record<TransferState, string>> = {
  sending: "Sending",
  paused: "Paused",
  waiting: "Waiting for the server",
  finishing: "Everything is sent",
  done: "Sent",
  failed: "",
};

export class TransferView {
  readonly node: HTMLElement;
  readonly pause = element("button", { type: "button", class: "button" }, "Pause");
  readonly cancel = element("button", { type: "button", class: "button quiet" }, "Cancel");
  readonly #bar = element("progress", { max: 1, value: 0, "aria-label": "Sent" });
  readonly #words = element("p", { class: "upload-words" });
  readonly #status = element("p", { class: "unseen", role: "status" }); // text for screen readers: not every byte
  readonly #summary = element("summary", {}, "Files");
  readonly #rows = element("ul", { class: "upload-files" });

  constructor(name: string) {
    this.node = element(
      "div",
      { class: "transfer" },
      element("strong", {}, name),
      this.#bar,
      this.#words,
      this.#status,
      element(
        "p",
        { class: "hint" },
        "If you close this page, choose the same folder again: the upload continues where it stopped.",
      ),
      element("div", { class: "actions" }, this.pause, this.cancel),
      element("details", {}, this.#summary, this.#rows),
    );
  }

  show(transfer: Transfer, perSecond: number | null): void {
    const { state, files, sent, total } = transfer;
    this.#bar.value = total > 0 ? sent / total : 1;
    const words = describeTransfer(transfer, perSecond);
    setText(this.#words, words);
    setText(this.#status, LABELS[state] || words);
    this.#words.classList.toggle("wrong", state === "failed");
    setText(this.pause, state === "failed" ? "Try again" : state === "paused" ? "Continue" : "Pause");
    this.pause.disabled = state === "finishing" || state === "done";
    const there = files.filter((file) => file.state === "there").length;
    setText(this.#summary, `${there.toLocaleString("en")} of ${files.length.toLocaleString("en")} files`);
    // active ones first, then pending ones
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
