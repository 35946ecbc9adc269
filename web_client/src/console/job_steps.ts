/** The progress of a running job: a bar for its stage, and its steps. */

import { element } from "../dom/element";
import type { Job } from "../protocol/api";
import { describeProgress, STEPS, stageOf, stepOf } from "./job_words";

export class JobSteps {
  readonly #bar = element("progress", { max: 1, value: 0 });
  readonly #steps = STEPS.map(({ name }) => element("li", {}, name));
  readonly #list = element("ol", { class: "job-steps" }, ...this.#steps);
  readonly node = element("div", { class: "job-progress" }, this.#bar, this.#list);

  show(job: Job): void {
    this.node.hidden = job.state !== "running";
    this.#bar.setAttribute("aria-label", describeProgress(job));
    if (job.progress && job.progress.total > 1) this.#bar.value = job.progress.done / job.progress.total;
    else this.#bar.removeAttribute("value");
    const at = stepOf(job);
    this.#list.hidden = at < 0 && stageOf(job) !== null; // an unknown stage has unknown predecessors
    this.#steps.forEach((step, i) => {
      step.dataset.state = i < at ? "done" : i === at ? "now" : "later";
      if (i === at) step.setAttribute("aria-current", "step");
      else step.removeAttribute("aria-current");
    });
  }
}
