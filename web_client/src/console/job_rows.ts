/** The jobs as rows: title, stage, progress with its figures, error, cancel. */

import { element, setText } from "../dom/element";
import { cancelJob, isFinal, isRetriable, type Job, retryJob } from "../protocol/api";
import { siteUrl } from "../protocol/http";
import { JobSteps } from "./job_steps";
import { describeFault, describeFigures, describeProgress, titleOf } from "./job_words";
import { showNodes } from "./shell";

export interface JobEvents {
  /** A job has changed on the server. */
  changed(): void;
  problem(error: unknown): void;
}

class JobRow {
  readonly node: HTMLElement;
  readonly #title = element("a", {});
  readonly #state = element("span", { class: "job-state" });
  readonly #figures = element("p", { class: "job-figures" });
  readonly #steps = new JobSteps();
  readonly #error = element("p", { class: "job-error" });
  readonly #cancel = element("button", { type: "button", class: "button quiet" }, "Cancel");
  readonly #retry = element("button", { type: "button", class: "button quiet" }, "Try again");
  readonly #open = element("a", { class: "button" }, "Watch");
  #id = "";

  constructor(events: JobEvents) {
    this.#cancel.addEventListener("click", () => this.#ask(this.#cancel, cancelJob, events));
    this.#retry.addEventListener("click", () => this.#ask(this.#retry, retryJob, events));
    this.node = element(
      "li",
      { class: "job" },
      element(
        "div",
        { class: "job-head" },
        element("h3", { class: "job-title" }, this.#title),
        this.#state,
        this.#open,
        this.#retry,
        this.#cancel,
      ),
      this.#steps.node,
      this.#figures,
      this.#error,
    );
  }

  /**
   * Show a job.
   *
   * @param published the existing scenes
   */
  update(job: Job, published: ReadonlySet<string>): void {
    this.#id = job.id;
    this.node.dataset.state = job.state;
    setText(this.#title, titleOf(job));
    this.#title.title = job.capture;
    this.#title.href = siteUrl(`job/${encodeURIComponent(job.id)}`);
    setText(this.#state, describeProgress(job));
    setText(this.#figures, describeFigures(job));
    setText(this.#error, describeFault(job));
    this.#steps.show(job);
    this.#cancel.hidden = isFinal(job);
    this.#cancel.disabled = this.#retry.disabled = false;
    this.#retry.hidden = !isRetriable(job);
    this.#open.hidden = job.scene === null || !published.has(job.scene);
    if (job.scene !== null) this.#open.href = siteUrl(`view/${encodeURIComponent(job.scene)}`);
    for (const button of [this.#cancel, this.#retry, this.#open])
      button.setAttribute("aria-label", `${button.textContent}: ${titleOf(job)}`);
  }

  /** Request a change; the row follows with the job's next news. */
  #ask(button: HTMLButtonElement, request: (id: string) => Promise<void>, events: JobEvents): void {
    button.disabled = true;
    request(this.#id).then(events.changed, (error: Error) => {
      button.disabled = false;
      events.problem(error);
    });
  }
}

/** The rows, created once per job and updated in place. */
export class JobRows {
  readonly #rows = new Map<string, JobRow>();
  #published: ReadonlySet<string> = new Set();

  constructor(
    readonly list: HTMLElement,
    readonly events: JobEvents,
  ) {}

  show(jobs: readonly Job[], published: ReadonlySet<string>): void {
    this.#published = published;
    for (const id of this.#rows.keys()) if (!jobs.some((job) => job.id === id)) this.#rows.delete(id);
    showNodes(
      this.list,
      jobs.map((job) => this.update(job)),
    );
  }

  /** Show a job's news; returns its row. */
  update(job: Job): HTMLElement {
    const row = this.#rows.get(job.id) ?? new JobRow(this.events);
    this.#rows.set(job.id, row);
    row.update(job, this.#published);
    return row.node;
  }
}
