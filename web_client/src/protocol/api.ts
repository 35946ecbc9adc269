/** Jobs and scenes over HTTP; the objects are those of docs/protocol.md. */

export interface Scene {
  readonly id: string;
  readonly title: string;
  readonly created: number;
  readonly start: number;
  readonly end: number;
  readonly bytes_total: number;
  readonly splats_static: number;
  readonly splats_dynamic: number;
}

export interface JobProgress {
  readonly stage: string;
  readonly done: number;
  readonly total: number;
  readonly figures: Readonly<Record<string, number>>;
}

export type JobState = "queued" | "running" | "succeeded" | "failed" | "cancelled";

export interface Job {
  readonly id: string;
  readonly state: JobState;
  readonly capture: string;
  readonly title: string | null;
  readonly preset: string;
  readonly stage: string | null;
  readonly progress: JobProgress | null;
  readonly error: string | null;
  /** Why a job that is not finished does not go on at the moment. */
  readonly waiting: string | null;
  readonly scene: string | null;
  readonly created: number;
  readonly updated: number;
}

export const isFinal = (job: Job): boolean => job.state !== "queued" && job.state !== "running";

export const thumbnailUrl = (scene: string): string => `/v1/scenes/${encodeURIComponent(scene)}/thumbnail`;

/** The server answered with a problem, or not at all; the message is one line for people. */
export class ApiError extends Error {}

async function request(path: string, init: RequestInit = {}): Promise<Response> {
  let response: Response;
  try {
    response = await fetch(path, init);
  } catch {
    throw new ApiError("The server cannot be reached.");
  }
  if (!response.ok) {
    const { detail } = await fields(response);
    const reason = typeof detail === "string" ? detail : response.statusText;
    throw new ApiError(`The server answered ${response.status}: ${reason}`);
  }
  return response;
}

/** The members of a JSON body; none if it is something else. */
async function fields(response: Response): Promise<Record<string, unknown>> {
  const body: unknown = await response.json().catch(() => null);
  return typeof body === "object" && body !== null ? (body as Record<string, unknown>) : {};
}

async function requestJson(path: string, signal: AbortSignal): Promise<Record<string, unknown>> {
  return fields(await request(path, { signal, headers: { Accept: "application/json" } }));
}

/** @throws ApiError */
export async function listScenes(signal: AbortSignal): Promise<Scene[]> {
  return ((await requestJson("/v1/scenes", signal)).scenes ?? []) as Scene[];
}

/** @throws ApiError */
export async function listJobs(signal: AbortSignal): Promise<Job[]> {
  return ((await requestJson("/v1/jobs", signal)).jobs ?? []) as Job[];
}

/** @throws ApiError */
export async function cancelJob(id: string): Promise<void> {
  await request(`/v1/jobs/${encodeURIComponent(id)}/cancel`, { method: "POST" });
}

/**
 * Queue a failed or cancelled job again; it goes on from its last checkpoint.
 *
 * @throws ApiError
 */
export async function retryJob(id: string): Promise<void> {
  await request(`/v1/jobs/${encodeURIComponent(id)}/retry`, { method: "POST" });
}

/** Call `onJob` at every change of a job until it is final or the returned function is called. */
export function followJob(id: string, onJob: (job: Job) => void): () => void {
  const source = new EventSource(`/v1/jobs/${encodeURIComponent(id)}/events`);
  source.addEventListener("job", (event) => {
    const job = JSON.parse((event as MessageEvent<string>).data) as Job;
    onJob(job);
    if (isFinal(job)) source.close();
  });
  return () => source.close();
}
