/** The page of one job: its progress, its figures, its log, and its result. */

import { element, setText } from "../dom/element";
import {
  cancelJob,
  followJob,
  getJob,
  getJobHistory,
  getJobRun,
  isFinal,
  isRetriable,
  type Job,
  type JobRun,
  pictureUrl,
  reportUrl,
  retryJob,
} from "../protocol/api";
import { siteUrl } from "../protocol/http";
import { configTable } from "./config_table";
import { JobChart } from "./job_chart";
import { JobCourse } from "./job_course";
import { JobLogPanel } from "./job_log";
import { JobSteps } from "./job_steps";
import {
  captureName,
  describeFault,
  describeFigures,
  describeProgress,
  describeQueue,
  describeRemaining,
  describeSound,
  titleOf,
} from "./job_words";
import { showNotFoundPage } from "./not_found_page";
import { isMissing, type Shell, showShell } from "./shell";
import "./job.css";

export class JobPicture {
  readonly #caption = element("figcaption", { class: "hint" }, "The first picture appears once training starts.");
  readonly node = element("figure", { class: "job-picture" }, this.#caption);
  #version: string | null = null;
  #shown: HTMLImageElement | null = null;

  constructor(readonly job: string) {}

  /** Show the picture of a version; the previous one stays until it has loaded. */
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
        if (version === this.#version) this.#version = null; // it was replaced meanwhile: try again
      },
    );
  }
}

const LOOK = 3000; // ms between two requests for data without events: picture, queue, log

export function showJobPage(root: HTMLElement, id: string): void {
  document.title = "Job · HGS";
  const shell = showShell(root, "job-page", element("a", { class: "button", href: siteUrl("") }, "All scenes"));
  const abort = new AbortController();
  addEventListener("pagehide", () => abort.abort(), { once: true });
  getJob(id, abort.signal).then(
    (job) => new JobView(job, shell, abort.signal),
    (error: unknown) => {
      if (abort.signal.aborted) return;
      if (!isMissing(error)) return shell.problem(error);
      showNotFoundPage(root, siteUrl(""), "There is no such job", "The link may be mistyped, or the job deleted.");
    },
  );
}

class JobView {
  readonly #title = element("h1", {});
  readonly #about = element("p", { class: "hint" });
  readonly #state = element("p", { class: "job-state", role: "status" });
  readonly #remaining = element("span", { class: "job-remaining" });
  readonly #figures = element("p", { class: "job-figures" });
  readonly #fault = element("p", { class: "job-error" });
  readonly #watch = element("a", { class: "button primary", hidden: true }, "Watch the scene");
  readonly #report = element("a", { class: "button", hidden: true, target: "_blank", rel: "noopener" }, "Report");
  readonly #cancel = element("button", { type: "button", class: "button" }, "Cancel");
  readonly #retry = element("button", { type: "button", class: "button" }, "Try again");
  readonly #steps = new JobSteps();
  readonly #status = element("section", { class: "job", "aria-label": "Progress" });
  readonly #picture: JobPicture;
  readonly #chart = new JobChart();
  readonly #log: JobLogPanel;
  readonly #course = new JobCourse();
  #run: JobRun | null = null;
  #stop = (): void => {};
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private job: Job,
    readonly shell: Shell,
    readonly signal: AbortSignal,
  ) {
    this.#picture = new JobPicture(job.id);
    this.#log = new JobLogPanel(job.id, signal);
    this.#report.href = reportUrl(job.id);
    this.#cancel.addEventListener("click", () => void this.#ask(this.#cancel, cancelJob));
    this.#retry.addEventListener("click", () => void this.#ask(this.#retry, retryJob));
    this.#status.append(
      element("div", { class: "job-head" }, this.#state, this.#remaining),
      this.#steps.node,
      this.#figures,
      this.#fault,
    );
    shell.main.append(
      element(
        "div",
        { class: "page-head" },
        element("div", {}, this.#title, this.#about),
        element("div", { class: "actions" }, this.#watch, this.#report, this.#retry, this.#cancel),
      ),
      this.#status,
      element("div", { class: "job-views" }, this.#picture.node, this.#chart.node),
      this.#log.node,
      configTable(job.config),
    );
    signal.addEventListener("abort", () => {
      this.#stop();
      clearTimeout(this.#timer);
    });
    document.addEventListener("visibilitychange", () => document.hidden || void this.#look(), { signal });
    this.#follow();
  }

  /** Follow the job from its present state. */
  #follow(): void {
    this.#show(this.job);
    this.#stop();
    this.#stop = isFinal(this.job) ? () => {} : followJob(this.job.id, (news) => this.#show(news));
    this.#readCourse();
    void this.#look();
  }

  /** Load the stored course of the job. */
  #readCourse(): void {
    getJobHistory(this.job.id, this.signal).then(
      (points) => {
        this.#course.start(points);
        this.#show(this.job);
      },
      (error: unknown) => this.signal.aborted || this.shell.problem(error),
    );
  }

  #show(job: Job): void {
    const ended = isFinal(job) && !isFinal(this.job);
    this.job = job;
    this.#course.follow(job);
    const title = titleOf(job);
    const percent = job.state === "running" && job.progress && job.progress.total > 1;
    const share = percent ? `${Math.floor((100 * job.progress.done) / job.progress.total)}% · ` : "";
    document.title = `${share}${title} · HGS`;
    setText(this.#title, title);
    const about = [
      `From ${captureName(job)}`,
      job.preset ? `preset ${job.preset}` : "",
      describeSound(job),
      job.attempt > 1 ? `attempt ${job.attempt}` : "",
    ];
    setText(this.#about, about.filter(Boolean).join(" · "));
    this.#about.title = job.capture;
    this.#status.dataset.state = job.state;
    setText(this.#state, describeProgress(job));
    const queue = job.state === "queued" && !job.waiting ? describeQueue(this.#run?.ahead ?? null) : "";
    setText(this.#remaining, queue || describeRemaining(job));
    setText(this.#figures, describeFigures(job));
    setText(this.#fault, describeFault(job));
    this.#steps.show(job);
    this.#cancel.hidden = isFinal(job);
    this.#retry.hidden = !isRetriable(job);
    this.#chart.show(this.#course);
    this.#log.follow(!isFinal(job));
    if (!ended) return;
    this.#readCourse(); // news are thinned out: a stage's last report may be missing
    void this.#look();
  }

  /** Request the data that no event reports, and again later while the job continues. */
  async #look(): Promise<void> {
    clearTimeout(this.#timer);
    try {
      const run = await getJobRun(this.job.id, this.signal);
      this.#run = run;
      this.#picture.show(run.picture);
      this.#picture.node.hidden = run.picture === null && isFinal(this.job);
      this.#report.hidden = !run.report;
      this.#watch.hidden = run.scene === null;
      if (run.scene !== null) this.#watch.href = siteUrl(`view/${encodeURIComponent(run.scene)}`);
      this.shell.problem(null);
      this.#show(this.job);
    } catch (error) {
      if (this.signal.aborted) return;
      this.shell.problem(error);
    }
    clearTimeout(this.#timer);
    if (!document.hidden && !isFinal(this.job)) this.#timer = setTimeout(() => void this.#look(), LOOK);
  }

  async #ask(button: HTMLButtonElement, request: (id: string) => Promise<void>): Promise<void> {
    button.disabled = true;
    try {
      await request(this.job.id);
      this.job = await getJob(this.job.id, this.signal);
      this.#follow();
    } catch (error) {
      this.shell.problem(error);
    }
    button.disabled = false;
  }
}
