/** Captures, jobs and scenes over HTTP, with the objects of docs/rest.md. All functions throw `ApiError`. */

import { toHex } from "../codec/hex";
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
  /** Whether the scene is still growing. */
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
  /** The sound: "auto", "none", "camera:" and a name, or the path of a file; null if unknown. */
  readonly audio: string | null;
  readonly stage: string | null;
  readonly progress: JobProgress | null;
  readonly error: string | null;
  /** The reason for which an unfinished job does not run at the moment. */
  readonly waiting: string | null;
  readonly scene: string | null;
  /** The expected end of a running job, seconds since 1970; null if unknown. */
  readonly ends: number | null;
  readonly created: number;
  readonly updated: number;
}

/** A stored progress report of a stage. */
export interface JobPoint extends JobProgress {
  readonly attempt: number;
  /** Seconds since 1970. */
  readonly time: number;
}

/** Further data of a job. */
export interface JobRun {
  /** Number of waiting jobs that were queued earlier; null unless this job waits itself. */
  readonly ahead: number | null;
  /** A string that changes with the picture; null while there is none. */
  readonly picture: string | null;
  readonly report: boolean;
  /** Its published scene. */
  readonly scene: string | null;
}

export interface JobLog {
  readonly lines: readonly string[];
  readonly complete: boolean;
}

export interface TrainingPrice {
  readonly minutes: number;
  /** The most that the scene has. */
  readonly bytes: number;
}

export interface Capture {
  readonly capture: string;
  readonly name: string;
  /** Null for an upload that is no capture. */
  readonly layout: string | null;
  readonly cameras: readonly string[];
  readonly frames: number | null;
  readonly seconds: number | null;
  readonly problem: string | null;
  /** The first picture of its first camera, a data URI of 192x144 pixels at most. */
  readonly picture?: string | null;
  /** Predictions for trainings on the server, by preset. */
  readonly presets?: Readonly<Record<string, TrainingPrice>> | null;
  /** Whether its check is not finished; then `problem` contains a text, too. */
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
  /** The held-out cameras; the server chooses if undefined. */
  readonly hold_out?: readonly string[];
  /** Overrides of the config, by path. */
  readonly config?: Readonly<Record<string, unknown>>;
}

export const isFinal = (job: Job): boolean => !["queued", "running", "waiting"].includes(job.state);

/** Whether the server accepts a retry: it tries a waiting job again at once. */
export const isRetriable = (job: Job): boolean => ["waiting", "failed", "cancelled"].includes(job.state);

const sceneAddress = (id: string): string => siteUrl(`v1/scenes/${encodeURIComponent(id)}`);
const jobAddress = (id: string): string => siteUrl(`v1/jobs/${encodeURIComponent(id)}`);

export const thumbnailUrl = (scene: string): string => `${sceneAddress(scene)}/thumbnail`;
export const reportUrl = (job: string): string => `${jobAddress(job)}/report`;

/** The address of a job's picture; `version` is `JobRun.picture`, so that browsers fetch each new one. */
export const pictureUrl = (job: string, version: string): string =>
  `${jobAddress(job)}/picture?version=${encodeURIComponent(version)}`;

export async function listScenes(signal: AbortSignal): Promise<Scene[]> {
  return ((await getJson(siteUrl("v1/scenes"), signal)).scenes ?? []) as Scene[];
}

/**
 * Request a scene.
 *
 * @param query the link of a visitor, such as `?link=…`, or ""
 * @throws ApiError
 */
export async function getScene(id: string, signal: AbortSignal, query = ""): Promise<Scene> {
  return (await getJson(sceneAddress(id) + query, signal)) as unknown as Scene;
}

export async function renameScene(id: string, title: string): Promise<void> {
  await sendJson("PATCH", sceneAddress(id), { title });
}

/** A new key for requests of which the server takes one, however often it arrives; also without a secure context. */
export const newIdempotencyKey = (): string => toHex(crypto.getRandomValues(new Uint8Array(16)));

/** Queue a job that makes a new scene of this one, by an edit as JSON text (docs/editing.md). */
export async function editScene(id: string, body: string, key: string): Promise<Job> {
  const headers = { Accept: "application/json", "Content-Type": "application/json", "Idempotency-Key": key };
  return (await (await request(`${sceneAddress(id)}/edits`, { method: "POST", headers, body })).json()) as Job;
}

export async function deleteScene(id: string): Promise<void> {
  await request(sceneAddress(id), { method: "DELETE" });
}

export async function listCaptures(signal: AbortSignal): Promise<CaptureList> {
  const answer = await getJson(siteUrl("v1/captures"), signal);
  return { captures: [], folders: [], complete: true, ...answer };
}

/** The first pictures of a capture's cameras as data URIs, by name; null for an unreadable one. */
export async function getCameraPictures(capture: string, signal: AbortSignal): Promise<Record<string, string | null>> {
  const path = siteUrl(`v1/captures/pictures?capture=${encodeURIComponent(capture)}`);
  return ((await getJson(path, signal)).pictures ?? {}) as Record<string, string | null>;
}

/** The identity of this browser at the server. */
export interface Session {
  /** Whether the server requires keys at all. */
  readonly needed: boolean;
  /** Name of the given key; null without one. */
  readonly name: string | null;
}

export async function getSession(signal: AbortSignal): Promise<Session> {
  return { needed: false, name: null, ...(await getJson(siteUrl("v1/session"), signal)) };
}

/** Present a key; the browser keeps a cookie for it. */
export async function beginSession(key: string): Promise<void> {
  await sendJson("POST", siteUrl("v1/session"), { key });
}

export async function endSession(): Promise<void> {
  await request(siteUrl("v1/session"), { method: "DELETE" });
}

/**
 * Create a link for visitors without a key, valid for a number of seconds: the parameter `link` of the scene's page.
 */
export async function makeLink(scene: string, seconds: number): Promise<string> {
  return String((await sendJson("POST", siteUrl("v1/links"), { scene, seconds })).link);
}

/** Submit a capture, and wait until the server has checked it; `onWait` is called if that takes a while. */
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

/** Queue a failed or cancelled job again; it continues from its last checkpoint. */
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
