/** The texts about a job. */

import { isFinal, type Job } from "../protocol/api";

/** The steps of a job, in order, with their stages of docs/rest.md. */
export const STEPS: readonly { readonly name: string; readonly stages: readonly string[] }[] = [
  { name: "Checking the capture", stages: ["initialise", "sync", "cameras", "check"] },
  { name: "Finding what moves", stages: ["frames", "masks"] },
  { name: "Placing points", stages: ["points"] },
  { name: "Training", stages: ["train"] },
  { name: "Encoding", stages: ["encode"] },
  { name: "Publishing", stages: ["publish"] },
];

const STATE_NAMES: Readonly<Record<Job["state"], string>> = {
  queued: "Queued",
  running: "Running",
  waiting: "Waiting",
  succeeded: "Done",
  failed: "Failed",
  cancelled: "Cancelled",
};

const FIGURE_NAMES: Readonly<Record<string, string>> = {
  psnr: "PSNR",
  loss: "Loss",
  static: "Still splats",
  dynamic: "Moving splats",
};

const UNITS: Readonly<Record<string, string>> = { psnr: " dB" };

export const stageOf = (job: Job): string | null => job.progress?.stage ?? job.stage;

/** The title of a job, or else the name of its capture's folder. */
export const titleOf = (job: Job): string => job.title || captureName(job) || job.id;

export const captureName = (job: Job): string => job.capture.split("/").filter(Boolean).at(-1) ?? "";

const CAMERA_SOUND = "camera:";

/** The sound, if it is not the capture's own: "no sound", "sound of cam01", "sound of recorder.wav". */
export function describeSound({ audio }: Job): string {
  if (!audio || audio === "auto") return "";
  if (audio === "none") return "no sound";
  return `sound of ${audio.startsWith(CAMERA_SOUND) ? audio.slice(CAMERA_SOUND.length) : audio.split("/").at(-1)}`;
}

/** A name in words: "Depth maps" for `depth_maps`. */
export function spelledOut(name: string): string {
  const words = name.replace(/[_-]+/g, " ").trim();
  return words.charAt(0).toUpperCase() + words.slice(1);
}

export const figureName = (name: string): string => FIGURE_NAMES[name] ?? spelledOut(name);

/** "27.3 dB", "48,210", "0.0412": three digits, but counts whole. */
export function figureText(name: string, value: number): string {
  const text = Number.isInteger(value) ? value.toLocaleString("en") : Number(value.toPrecision(3)).toString();
  return text + (UNITS[name] ?? "");
}

/** The index of a job's step; -1 before the first, and in a stage unknown to this page. */
export function stepOf(job: Job): number {
  const stage = stageOf(job);
  return stage === null ? -1 : STEPS.findIndex(({ stages }) => stages.includes(stage));
}

/** "Training 420 / 2,000"; a stage unknown to this page by its own name, "Depth maps 3 / 16". */
export function describeProgress(job: Job): string {
  if (job.state !== "running") return STATE_NAMES[job.state];
  const stage = stageOf(job);
  if (stage === null) return "Starting";
  const name = STEPS[stepOf(job)]?.name ?? spelledOut(stage);
  const { done, total } = job.progress ?? { done: 0, total: 0 };
  return total > 1 ? `${name} ${done.toLocaleString("en")} / ${total.toLocaleString("en")}` : name;
}

/** The problem: the reason of a failure, or of waiting. */
export function describeFault(job: Job): string {
  return job.error ?? (isFinal(job) || !job.waiting ? "" : `Waiting: ${job.waiting}`);
}

/** "PSNR 28.3 dB · Loss 0.041" */
export function describeFigures(job: Job): string {
  if (job.state !== "running" || !job.progress) return "";
  const figures = Object.entries(job.progress.figures);
  return figures.map(([name, value]) => `${figureName(name)} ${figureText(name, value)}`).join(" · ");
}

/** The place of a queued job, if it is known. */
export function describeQueue(ahead: number | null): string {
  if (ahead === null) return "";
  if (ahead === 0) return "Next in line: it starts as soon as a worker is free.";
  return ahead === 1
    ? "One other job is ahead of it."
    : `About ${ahead.toLocaleString("en")} other jobs are ahead of it.`;
}

/** "about 12 min left" until the scene is published; "" while unknown. */
export function describeRemaining({ ends, updated }: Job): string {
  if (ends === null) return "";
  const seconds = ends - updated;
  if (seconds < 60) return "less than a minute left";
  const minutes = Math.round(seconds / 60);
  if (minutes < 90) return `about ${minutes} min left`;
  return `about ${Math.round(minutes / 60)} h left`;
}
