/** The page that lists scenes and jobs, and keeps both up to date. */

import { ApiError, followJob, isFinal, type Job, listJobs, listScenes } from "../protocol/api";
import { element } from "./element";
import { JobRows } from "./job_rows";
import { showScenes } from "./scene_cards";

const REFRESH = 5000; // ms
/** Event streams at once: browsers open six connections per server over HTTP/1.1, and the page needs some for itself. */
const FOLLOWED = 3;
const FINISHED_SHOWN = 8;

export function showListPage(root: HTMLElement): void {
  document.title = "HGS · Scenes";
  const scenes = element("ul", { class: "cards" });
  const noScenes = element(
    "div",
    { class: "empty", hidden: true },
    element("p", {}, "No scene yet."),
    element("p", { class: "hint" }, "Train one on this machine with "),
  );
  noScenes.lastElementChild?.append(element("code", {}, "hgs train CAPTURE --out RUN"), ", or submit a capture to ");
  noScenes.lastElementChild?.append(element("code", {}, "POST /v1/jobs"), ".");
  const jobs = element("ul", { class: "jobs" });
  const jobSection = element("section", { hidden: true }, element("h2", {}, "Jobs"), jobs);
  const alert = element("p", { class: "alert", role: "alert", hidden: true });
  root.className = "list-page";
  root.replaceChildren(
    element(
      "header",
      { class: "masthead" },
      element("img", { src: "/icon.svg", alt: "", width: 36, height: 36 }),
      element("div", {}, element("h1", {}, "HGS"), element("p", {}, "Moving scenes, streamed as Gaussian splats")),
    ),
    element("main", {}, alert, element("section", {}, element("h2", {}, "Scenes"), scenes, noScenes), jobSection),
  );

  const rows = new JobRows(jobs, showProblem);
  const followed = new Map<string, () => void>();
  const abort = new AbortController();
  let timer: ReturnType<typeof setTimeout> | undefined;

  function showProblem(message: string): void {
    alert.hidden = message === "";
    alert.textContent = message;
  }

  function follow(all: readonly Job[]): void {
    const active = all.filter((job) => !isFinal(job));
    for (const [id, stop] of followed) {
      if (active.some((job) => job.id === id)) continue;
      stop();
      followed.delete(id);
    }
    const first = [...active].sort((a, b) => Number(b.state === "running") - Number(a.state === "running"));
    for (const job of first) {
      if (followed.has(job.id) || followed.size >= FOLLOWED) continue;
      const stop = followJob(job.id, (news) => {
        rows.update(news);
        if (isFinal(news)) void refresh(); // a new scene may be there
      });
      followed.set(job.id, stop);
    }
  }

  async function refresh(): Promise<void> {
    clearTimeout(timer);
    try {
      const [allScenes, allJobs] = await Promise.all([listScenes(abort.signal), listJobs(abort.signal)]);
      showScenes(scenes, allScenes);
      noScenes.hidden = allScenes.length > 0;
      let finished = 0;
      const shown = allJobs.filter((job) => !isFinal(job) || finished++ < FINISHED_SHOWN);
      rows.show(shown);
      jobSection.hidden = shown.length === 0;
      follow(allJobs);
      showProblem("");
    } catch (error) {
      if (abort.signal.aborted) return;
      showProblem(error instanceof ApiError ? error.message : String(error));
    }
    if (!document.hidden && !abort.signal.aborted) timer = setTimeout(() => void refresh(), REFRESH);
  }

  document.addEventListener("visibilitychange", () => (document.hidden ? clearTimeout(timer) : void refresh()), {
    signal: abort.signal,
  });
  addEventListener(
    "pagehide",
    () => {
      abort.abort();
      clearTimeout(timer);
      for (const stop of followed.values()) stop();
    },
    { signal: abort.signal },
  );
  void refresh();
}
