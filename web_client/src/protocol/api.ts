/** Captures, jobs and scenes over HTTP; the objects are those of docs/rest.md. All functions throw `ApiError`. */

import { ApiError, getJson, request, sendJson, siteUrl } from "./http";

export { ApiError };

const POLL_MS = 1000;

export interface Scene {
  readonly id: string;
  readonly title: string;
  readonly created: number;
  readonly start: number;
  readonly end: number;
  readonly bytes_total: number;
  readonly splats_static: number;
  readonly splats_dynamic: number;
  /** Whether it grows. */
  readonly live: boolean;
}

export interface JobProgress {
  readonly stage: string;
  readonly done: number;
  readonly total: number;
  readonly figures: Readonly<Record<string, number>>;
}

export type JobState = "queued" | "running" | "waiting" | "succeeded" | "failed" | "cancelled";

export interface Job {
  readonly id: string;
  readonly state: JobState;
  readonly attempt: number;
  readonly capture: string;
  readonly title: string | null;
  readonly preset: string | null;
  readonly config: Readonly<Record<string, unknown>>;
  /** What is heard: "auto", "none", "camera:" and a name, or the path of a file; null where that is not known. */
  readonly audio: string | null;
  readonly stage: string | null;
  readonly progress: JobProgress | null;
  readonly error: string | null;
  /** Why a job that is not finished does not go on at the moment. */
  readonly waiting: string | null;
  readonly scene: string | null;
  readonly created: number;
  readonly updated: number;
}

/** One report of a stage that was kept. */
export interface JobPoint extends JobProgress {
  readonly attempt: number;
  /** Seconds since 1970. */
  readonly time: number;
}

/** What else there is of a job. */
export interface JobRun {
  /** Jobs that were queued before it and still wait; null unless it waits itself. */
  readonly ahead: number | null;
  /** Another string after every change of the picture; null while there is none. */
  readonly picture: string | null;
  readonly report: boolean;
  /** Its scene, while that is published. */
  readonly scene: string | null;
}

export interface JobLog {
  readonly lines: readonly string[];
  readonly complete: boolean;
}

export interface Capture {
  readonly capture: string;
  readonly name: string;
  /** Null of what was sent and is no capture. */
  readonly layout: string | null;
  readonly cameras: readonly string[];
  readonly frames: number | null;
  readonly seconds: number | null;
  readonly problem: string | null;
  /** Whether it is still being looked at, which `problem` says, too. */
  readonly looking?: boolean;
}

export interface CaptureList {
  readonly captures: readonly Capture[];
  readonly folders: readonly { readonly path: string; readonly exists: boolean }[];
  readonly complete: boolean;
}

export interface Submission {
  readonly capture: string;
  readonly title: string;
  readonly preset: string;
  /** Without it the server chooses. */
  readonly hold_out?: readonly string[];
  /** Overrides of the config, by path. */
  readonly config?: Readonly<Record<string, unknown>>;
}

export const isFinal = (job: Job): boolean => !["queued", "running", "waiting"].includes(job.state);

/** Whether the server takes a retry: it tries a waiting job at once. */
export const isRetriable = (job: Job): boolean => ["waiting", "failed", "cancelled"].includes(job.state);

const sceneAddress = (id: string): string => siteUrl(`v1/scenes/${encodeURIComponent(id)}`);
const jobAddress = (id: string): string => siteUrl(`v1/jobs/${encodeURIComponent(id)}`);

export const thumbnailUrl = (scene: string): string => `${sceneAddress(scene)}/thumbnail`;
export const reportUrl = (job: string): string => `${jobAddress(job)}/report`;

/** The address of a job's picture; `version` is that of `JobRun.picture`, so that browsers fetch a new one. */
export const pictureUrl = (job: string, version: string): string =>
  `${jobAddress(job)}/picture?version=${encodeURIComponent(version)}`;

export async function listScenes(signal: AbortSignal): Promise<Scene[]> {
  return ((await getJson(siteUrl("v1/scenes"), signal)).scenes ?? []) as Scene[];
}

/**
 * @param query of a link to the scene, such as `?link=…`, or ""
 * @throws ApiError
 */
export async function getScene(id: string, signal: AbortSignal, query = ""): Promise<Scene> {
  return (await getJson(sceneAddress(id) + query, signal)) as unknown as Scene;
}

export async function renameScene(id: string, title: string): Promise<void> {
  await sendJson("PATCH", sceneAddress(id), { title });
}

export async function deleteScene(id: string): Promise<void> {
  await request(sceneAddress(id), { method: "DELETE" });
}

export async function listCaptures(signal: AbortSignal): Promise<CaptureList> {
  const answer = await getJson(siteUrl("v1/captures"), signal);
  return { captures: [], folders: [], complete: true, ...answer };
}

/** Who the server takes this browser for. */
export interface Session {
  /** Whether a key is asked for at all. */
  readonly needed: boolean;
  /** Of the key that was given; null without one. */
  readonly name: string | null;
}

export async function getSession(signal: AbortSignal): Promise<Session> {
  return { needed: false, name: null, ...(await getJson(siteUrl("v1/session"), signal)) };
}

/** Give a key: the browser keeps a cookie of it. */
export async function beginSession(key: string): Promise<void> {
  await sendJson("POST", siteUrl("v1/session"), { key });
}

export async function endSession(): Promise<void> {
  await request(siteUrl("v1/session"), { method: "DELETE" });
}

/** Make a link with which anybody can watch a scene for so many seconds: the parameter `link` of its page. */
export async function makeLink(scene: string, seconds: number): Promise<string> {
  return String((await sendJson("POST", siteUrl("v1/links"), { scene, seconds })).link);
}

/** Submit a capture, and wait until the server has looked at it; `onWait` is called when that takes a while. */
export async function submitJob(submission: Submission, onWait: () => void = () => {}): Promise<Job> {
  const headers = { Accept: "application/json", "Content-Type": "application/json" };
  let answer = await request(siteUrl("v1/jobs"), { method: "POST", headers, body: JSON.stringify(submission) });
  while (answer.status === 202) {
    onWait();
    const { id } = (await answer.json()) as { id: string };
    await new Promise((resolve) => setTimeout(resolve, POLL_MS));
    answer = await request(siteUrl(`v1/submissions/${encodeURIComponent(id)}`), {
      headers: { Accept: "application/json" },
    });
  }
  return (await answer.json()) as Job;
}

export async function listJobs(signal: AbortSignal): Promise<Job[]> {
  return ((await getJson(siteUrl("v1/jobs"), signal)).jobs ?? []) as Job[];
}

export async function getJob(id: string, signal: AbortSignal): Promise<Job> {
  return (await getJson(jobAddress(id), signal)) as unknown as Job;
}

export async function getJobRun(id: string, signal: AbortSignal): Promise<JobRun> {
  return (await getJson(`${jobAddress(id)}/run`, signal)) as unknown as JobRun;
}

export async function getJobHistory(id: string, signal: AbortSignal): Promise<JobPoint[]> {
  return ((await getJson(`${jobAddress(id)}/history`, signal)).points ?? []) as JobPoint[];
}

export async function getJobLog(id: string, lines: number, signal: AbortSignal): Promise<JobLog> {
  return (await getJson(`${jobAddress(id)}/log?lines=${lines}`, signal)) as unknown as JobLog;
}

export async function cancelJob(id: string): Promise<void> {
  await request(`${jobAddress(id)}/cancel`, { method: "POST" });
}

/** Queue a failed or cancelled job again; it goes on from its last checkpoint. */
export async function retryJob(id: string): Promise<void> {
  await request(`${jobAddress(id)}/retry`, { method: "POST" });
}

/** Call `onJob` at every change of a job until it is final or the returned function is called. */
export function followJob(id: string, onJob: (job: Job) => void): () => void {
  const source = new EventSource(`${jobAddress(id)}/events`);
  source.addEventListener("job", (event) => {
    const job = JSON.parse((event as MessageEvent<string>).data) as Job;
    onJob(job);
    if (isFinal(job)) source.close();
  });
  return () => source.close();
}
