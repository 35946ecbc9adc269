/** The start of an edit, and the course of its job. */

import type { EditCourse } from "../clean/clean_panel";
import type { StartEdit } from "../clean/clean_tool";
import { editScene, followJob, type Job } from "../protocol/api";
import { siteUrl } from "../protocol/http";
import { describeFault, describeProgress } from "./job_words";

/** The course of an edit's job in one line; the scene that it has published, or else the job. */
export function courseOf(job: Job): EditCourse {
  const busy = ["queued", "running", "waiting"].includes(job.state);
  const link = job.scene
    ? { name: "Open the new scene", address: siteUrl(`view/${encodeURIComponent(job.scene)}`) }
    : { name: "Job", address: siteUrl(`job/${encodeURIComponent(job.id)}`) };
  const fault = describeFault(job);
  return { text: fault === "" ? `${describeProgress(job)}.` : fault, link, busy };
}

/** A function that starts edits of a scene; jobs are followed until `signal` aborts. */
export function editStarter(scene: string, signal: AbortSignal): StartEdit {
  return (list, show) => {
    show({ text: "Sending …", busy: true });
    editScene(scene, list).then(
      (job) => {
        show(courseOf(job));
        const stop = followJob(job.id, (later) => show(courseOf(later)));
        signal.addEventListener("abort", stop);
      },
      (error: Error) => show({ text: error.message, busy: false }),
    );
  };
}
