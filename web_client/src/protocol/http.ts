/** The page's own server: addresses, requests, and problem documents (docs/rest.md, Errors). */

let root = "/";

/**
 * Set the server's root.
 *
 * @param path its path, with a slash at its end, as browsers write it: `/`, `/hgs/`, `/my%20scenes/hgs/`.
 */
export function beginSiteAt(path: string): void {
  root = path;
}

/** The address of a path below the server's root, such as `v1/scenes`. */
export const siteUrl = (path: string): string => root + path;

/** The part of a page's address below the server's root, with a slash before it; all of it if it is not below. */
export const pathInSite = (path: string): string => (path.startsWith(root) ? path.slice(root.length - 1) : path);

/** Error for an answer with a problem, or for no answer; the message is one line for people. */
export class ApiError extends Error {
  /**
   * @param status of the answer; 0 without one
   * @param field path of the refused value, such as `config.seed`; "" if the answer has none
   */
  constructor(
    message: string,
    readonly status = 0,
    readonly code = "",
    readonly field = "",
  ) {
    super(message);
  }
}

/** Event of the window when the server requires a key. */
export const KEY_NEEDED = "hgs-key-needed";

/**
 * Send a request.
 *
 * @throws ApiError
 */
export async function request(path: string, init: RequestInit = {}): Promise<Response> {
  let response: Response;
  try {
    response = await fetch(path, init);
  } catch {
    throw new ApiError("The server cannot be reached.");
  }
  if (response.ok) return response;
  if (response.status === 401) dispatchEvent(new Event(KEY_NEEDED));
  const { detail, code, field } = await fields(response);
  const reason = text(detail) || response.statusText;
  throw new ApiError(`The server answered ${response.status}: ${reason}`, response.status, text(code), text(field));
}

/**
 * Request a JSON object.
 *
 * @throws ApiError
 */
export async function getJson(path: string, signal?: AbortSignal): Promise<Record<string, unknown>> {
  return fields(await request(path, { signal, headers: { Accept: "application/json" } }));
}

/**
 * Send a JSON object.
 *
 * @throws ApiError
 */
export async function sendJson(method: string, path: string, body: unknown): Promise<Record<string, unknown>> {
  const headers = { Accept: "application/json", "Content-Type": "application/json" };
  return fields(await request(path, { method, headers, body: JSON.stringify(body) }));
}

/** The members of a JSON body; none if it is no object. */
async function fields(response: Response): Promise<Record<string, unknown>> {
  const body: unknown = await response.json().catch(() => null);
  return typeof body === "object" && body !== null ? (body as Record<string, unknown>) : {};
}

const text = (value: unknown): string => (typeof value === "string" ? value : "");
