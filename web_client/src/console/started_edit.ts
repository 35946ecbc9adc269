/** The start of an edit, and the course of its job. */

import type { EditCourse, StartEdit } from "../dom/edit_application";
import { editScene, followJob, isFinal, type Job, newIdempotencyKey } from "../protocol/api";
import { siteUrl } from "../protocol/http";
import { describeFault, describeProgress } from "./job_words";

/** The course of an edit's job in one line; the scene that it has published, or else the job. */
export function courseOf(job: Job): EditCourse {
  const link = job.scene
    ? { name: "Open the new scene", address: siteUrl(`view/${encodeURIComponent(job.scene)}`) }
    : { name: "Job", address: siteUrl(`job/${encodeURIComponent(job.id)}`) };
  const fault = describeFault(job);
  return { text: fault === "" ? `${describeProgress(job)}.` : fault, link, busy: !isFinal(job) };
}

/**
 * A function that starts edits of a scene; jobs are followed until `signal` aborts.
 *
 * An equal document keeps its idempotency key until its job has failed or was cancelled: it makes one scene, whether a
 * click is repeated or an answer was lost.
 */
export function editStarter(scene: string, signal: AbortSignal): StartEdit {
  let asked = { document: "", key: "" };
  return (document, show) => {
    if (document !== asked.document || asked.key === "") asked = { document, key: newIdempotencyKey() };
    const mine = asked;
    const follow = (job: Job) => {
      if (job.state === "failed" || job.state === "cancelled") mine.key = "";
      show(courseOf(job));
    };
    show({ text: "Sending …", busy: true });
    editScene(scene, document, mine.key).then(
      (job) => {
        follow(job);
        if (isFinal(job)) return;
        const stop = followJob(job.id, follow);
        signal.addEventListener("abort", stop);
      },
      (error: Error) => show({ text: error.message, busy: false }),
    );
  };
}
