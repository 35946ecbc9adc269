/** The page of scenes and jobs, kept up to date. */

import { element, icon } from "../dom/element";
import { PLUS } from "../dom/icons";
import { ApiError, endSession, followJob, getSession, isFinal, type Job, listJobs, listScenes } from "../protocol/api";
import { siteUrl } from "../protocol/http";
import { JobRows } from "./job_rows";
import { SceneSection } from "./scene_section";
import { showShell } from "./shell";
import "./list.css";

const REFRESH = 5000; // ms
/** Parallel event streams: browsers open six connections per server over HTTP/1.1, and the page needs some itself. */
const FOLLOWED = 3;
const FINISHED_SHOWN = 8;

/** The jobs; none for a key that allows watching scenes only. */
async function allowedJobs(signal: AbortSignal): Promise<Job[]> {
  try {
    return await listJobs(signal);
  } catch (error) {
    if (error instanceof ApiError && error.status === 403) return [];
    throw error;
  }
}

/** Show the name of the browser's key, and a button to forget it. */
async function signedIn(masthead: HTMLElement, signal: AbortSignal): Promise<void> {
  const { name } = await getSession(signal).catch(() => ({ name: null }));
  if (name === null) return;
  const leave = () => void endSession().then(() => location.reload());
  masthead.append(element("button", { type: "button", class: "button", onclick: leave }, `Sign out ${name}`));
}

export function showListPage(root: HTMLElement): void {
  document.title = "Scenes · HGS";
  const create = element("a", { class: "button primary", href: siteUrl("new") }, icon(PLUS), "New scene");
  const shell = showShell(root, "list-page", create);
  const scenes = new SceneSection({ changed: () => void refresh(), notify: shell.notify });
  const jobs = element("ul", { class: "jobs" });
  const jobSection = element(
    "section",
    { hidden: true, "aria-labelledby": "jobs" },
    element("div", { class: "section-head" }, element("h2", { id: "jobs" }, "Jobs")),
    jobs,
  );
  scenes.node.hidden = true; // hidden until the scenes have arrived
  shell.main.append(element("h1", { class: "unseen" }, "Scenes and jobs"), scenes.node, jobSection);

  const rows = new JobRows(jobs, { changed: () => void refresh(), problem: shell.problem });
  const followed = new Map<string, () => void>();
  const abort = new AbortController();
  let timer: ReturnType<typeof setTimeout> | undefined;

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
        if (isFinal(news)) void refresh(); // there may be a new scene
      });
      followed.set(job.id, stop);
    }
  }

  async function refresh(): Promise<void> {
    clearTimeout(timer);
    try {
      const [allScenes, allJobs] = await Promise.all([listScenes(abort.signal), allowedJobs(abort.signal)]);
      scenes.show(allScenes);
      let finished = 0;
      const shown = allJobs.filter((job) => !isFinal(job) || finished++ < FINISHED_SHOWN);
      rows.show(shown, new Set(allScenes.map(({ id }) => id)));
      jobSection.hidden = shown.length === 0;
      scenes.node.hidden = false;
      follow(allJobs);
      shell.problem(null);
    } catch (error) {
      if (abort.signal.aborted) return;
      shell.problem(error);
    }
    if (!document.hidden && !abort.signal.aborted) timer = setTimeout(() => void refresh(), REFRESH);
  }

  void signedIn(shell.masthead, abort.signal);
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
