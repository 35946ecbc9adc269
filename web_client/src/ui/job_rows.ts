/** The jobs as rows: title, stage, progress with its figures, error, cancel. */

import { cancelJob, isFinal, type Job, retryJob } from "../protocol/api";
import { element, setText } from "./element";

/** The steps of a job, in order, and the stages of docs/protocol.md that each of them is. */
const STEPS: readonly { readonly name: string; readonly stages: readonly string[] }[] = [
  { name: "Finding what moves", stages: ["initialise", "masks"] },
  { name: "Placing points", stages: ["points"] },
  { name: "Training", stages: ["train"] },
  { name: "Encoding", stages: ["encode"] },
  { name: "Publishing", stages: ["publish"] },
];

const STATE_NAMES: Readonly<Record<Job["state"], string>> = {
  queued: "Waiting",
  running: "Running",
  succeeded: "Done",
  failed: "Failed",
  cancelled: "Cancelled",
};

const stageOf = (job: Job): string | null => job.progress?.stage ?? job.stage;

/** The index of the step that a job is at; -1 before the first, and in a stage that this page does not know. */
export function stepOf(job: Job): number {
  const stage = stageOf(job);
  return stage === null ? -1 : STEPS.findIndex(({ stages }) => stages.includes(stage));
}

/** "Training 420 / 2,000"; a stage that this page does not know by its own name, "Depth maps 3 / 16". */
export function describeProgress(job: Job): string {
  if (job.state !== "running") return STATE_NAMES[job.state];
  const stage = stageOf(job);
  if (stage === null) return "Starting";
  const words = stage.replace(/[_-]+/g, " ").trim();
  const name = STEPS[stepOf(job)]?.name ?? words.charAt(0).toUpperCase() + words.slice(1);
  const { done, total } = job.progress ?? { done: 0, total: 0 };
  return total > 1 ? `${name} ${done.toLocaleString("en")} / ${total.toLocaleString("en")}` : name;
}

/** What is wrong: why the job failed, or what keeps it waiting. */
export function describeFault(job: Job): string {
  return job.error ?? (isFinal(job) || !job.waiting ? "" : `Waiting: ${job.waiting}`);
}

/** "loss 0.041 · psnr 28.3" */
export function describeFigures(job: Job): string {
  if (job.state !== "running" || !job.progress) return "";
  const figures = Object.entries(job.progress.figures).map(([name, value]) => {
    const text = Number.isInteger(value) ? value.toLocaleString("en") : Number(value.toPrecision(3)).toString();
    return `${name.replaceAll("_", " ")} ${text}`;
  });
  return figures.join(" · ");
}

class JobRow {
  readonly node: HTMLElement;
  readonly #title = element("h3", { class: "job-title" });
  readonly #state = element("span", { class: "job-state" });
  readonly #figures = element("p", { class: "job-figures" });
  readonly #bar = element("progress", { max: 1, value: 0 });
  readonly #steps = STEPS.map(({ name }) => element("li", {}, name));
  readonly #stepList = element("ol", { class: "job-steps" }, ...this.#steps);
  readonly #error = element("p", { class: "job-error" });
  readonly #cancel = element("button", { type: "button", class: "button quiet" }, "Cancel");
  readonly #retry = element("button", { type: "button", class: "button quiet" }, "Try again");
  readonly #open = element("a", { class: "button" }, "Watch");
  #id = "";

  constructor(onError: (message: string) => void) {
    this.#cancel.addEventListener("click", () => this.#ask(this.#cancel, cancelJob, onError));
    this.#retry.addEventListener("click", () => this.#ask(this.#retry, retryJob, onError));
    this.node = element(
      "li",
      { class: "job" },
      element("div", { class: "job-head" }, this.#title, this.#state, this.#open, this.#retry, this.#cancel),
      this.#bar,
      this.#stepList,
      this.#figures,
      this.#error,
    );
  }

  update(job: Job): void {
    this.#id = job.id;
    this.node.dataset.state = job.state;
    setText(this.#title, job.title || job.capture.split("/").filter(Boolean).at(-1) || job.id);
    this.#title.title = job.capture;
    setText(this.#state, describeProgress(job));
    setText(this.#figures, describeFigures(job));
    setText(this.#error, describeFault(job));
    const running = job.state === "running";
    this.#bar.hidden = !running;
    this.#bar.setAttribute("aria-label", describeProgress(job));
    if (job.progress && job.progress.total > 1) this.#bar.value = job.progress.done / job.progress.total;
    else this.#bar.removeAttribute("value");
    const at = stepOf(job);
    this.#stepList.hidden = !running || (at < 0 && stageOf(job) !== null); // what came before an unknown stage is unknown
    this.#steps.forEach((step, i) => {
      step.dataset.state = i < at ? "done" : i === at ? "now" : "later";
    });
    this.#cancel.hidden = isFinal(job);
    this.#cancel.disabled = this.#retry.disabled = false;
    this.#retry.hidden = job.state !== "failed" && job.state !== "cancelled";
    this.#open.hidden = job.scene === null;
    if (job.scene !== null) this.#open.href = `/view/${encodeURIComponent(job.scene)}`;
  }

  /** Ask the server for a change; the row follows when the job's news come. */
  #ask(button: HTMLButtonElement, request: (id: string) => Promise<void>, onError: (message: string) => void): void {
    button.disabled = true;
    request(this.#id).catch((error: Error) => {
      button.disabled = false;
      onError(error.message);
    });
  }
}

/** Rows that are made once per job and updated in place. */
export class JobRows {
  readonly #rows = new Map<string, JobRow>();

  constructor(
    readonly list: HTMLElement,
    readonly onError: (message: string) => void,
  ) {}

  show(jobs: readonly Job[]): void {
    for (const id of this.#rows.keys()) if (!jobs.some((job) => job.id === id)) this.#rows.delete(id);
    const nodes = jobs.map((job) => this.update(job));
    const same = nodes.length === this.list.children.length && nodes.every((node, i) => node === this.list.children[i]);
    if (!same) this.list.replaceChildren(...nodes); // moving nodes would drop the focus
  }

  /** Show a job's news; returns its row. */
  update(job: Job): HTMLElement {
    const row = this.#rows.get(job.id) ?? new JobRow(this.onError);
    this.#rows.set(job.id, row);
    row.update(job);
    return row.node;
  }
}
