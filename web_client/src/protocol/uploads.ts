/**
 * Uploads of captures, and their check, with the objects and steps of docs/upload.md. All functions throw `ApiError`.
 */

import { ApiError, getJson, KEY_NEEDED, request, sendJson, siteUrl } from "./http";

export interface Upload {
  readonly id: string;
  readonly name: string;
  readonly state: "receiving" | "finished";
  readonly files: number;
  readonly bytes: number;
  readonly received: number;
  /** Seconds since 1970; null for a finished upload. */
  readonly expires: number | null;
  /** The path of the resulting capture. */
  readonly capture: string | null;
}

export interface UploadList {
  readonly uploads: readonly Upload[];
  readonly limits: { readonly quota: number; readonly upload: number; readonly file: number; readonly files: number };
}

/** A file known to the server. */
export interface RemoteFile {
  readonly path: string;
  readonly sha256: string;
  readonly offset: number;
  readonly verified: boolean;
}

export interface Announcement {
  readonly name: string;
  readonly files: number;
  readonly bytes: number;
  readonly key: string;
}

export interface Finding {
  readonly stops: boolean;
  readonly cameras: readonly string[];
  readonly problem: string;
  readonly cure: string;
}

export interface CaptureCheck {
  readonly state: "waiting" | "running" | "done" | "failed";
  readonly error: string | null;
  readonly seconds: number;
  readonly found: {
    readonly stops: boolean;
    readonly findings: readonly Finding[];
    readonly cameras: readonly {
      readonly name: string;
      readonly partners: number;
      readonly matches: number;
      readonly error: number | null;
      readonly ahead: number | null;
    }[];
  } | null;
}

const TUS = { "Tus-Resumable": "1.0.0" };
const STREAM = "application/offset+octet-stream";

const address = (id: string): string => siteUrl(`v1/uploads/${encodeURIComponent(id)}`);

export async function listUploads(signal?: AbortSignal): Promise<UploadList> {
  return (await getJson(siteUrl("v1/uploads"), signal)) as unknown as UploadList;
}

export async function deleteUpload(id: string): Promise<void> {
  await request(address(id), { method: "DELETE" });
}

/** Begin an upload, or continue the unfinished one of the same announcement: `resumed`. */
export async function beginUpload(
  announced: Announcement,
  signal: AbortSignal,
): Promise<{ upload: Upload; resumed: boolean }> {
  const headers = { Accept: "application/json", "Content-Type": "application/json" };
  const body = JSON.stringify(announced);
  const response = await request(siteUrl("v1/uploads"), { method: "POST", headers, body, signal });
  return { upload: (await response.json()) as Upload, resumed: response.status === 200 };
}

export async function listRemoteFiles(id: string, signal: AbortSignal): Promise<RemoteFile[]> {
  return ((await getJson(`${address(id)}/files`, signal)).files ?? []) as RemoteFile[];
}

/** Announce a file; returns its address and the number of bytes at the server. */
export async function announceFile(
  id: string,
  file: { readonly path: string; readonly size: number; readonly sha256: string },
  signal: AbortSignal,
): Promise<{ location: string; offset: number }> {
  const metadata = `path ${base64(file.path)},sha256 ${base64(file.sha256)}`;
  const headers = { ...TUS, "Upload-Length": String(file.size), "Upload-Metadata": metadata };
  const response = await request(`${address(id)}/files`, { method: "POST", headers, signal });
  const location = new URL(response.headers.get("Location") ?? "", response.url).href;
  return { location, offset: offsetIn(response.headers.get("Upload-Offset")) };
}

/** The number of a file's bytes at the server. */
export async function remoteOffset(location: string, signal: AbortSignal): Promise<number> {
  const response = await request(location, { method: "HEAD", signal, cache: "no-store" });
  return offsetIn(response.headers.get("Upload-Offset"));
}

/**
 * Send the next bytes of a file; returns the number of bytes at the server afterwards.
 *
 * @param onBytes is called with the number of bytes of the piece that are sent
 */
export function sendPiece(
  location: string,
  offset: number,
  piece: Blob,
  onBytes: (bytes: number) => void,
  signal: AbortSignal,
): Promise<number> {
  return new Promise((resolve, reject) => {
    const sending = new XMLHttpRequest(); // fetch reports no progress of uploads
    sending.open("PATCH", location);
    for (const [name, value] of Object.entries({ ...TUS, "Upload-Offset": String(offset), "Content-Type": STREAM }))
      sending.setRequestHeader(name, value);
    const stop = () => sending.abort();
    signal.addEventListener("abort", stop, { once: true });
    sending.upload.onprogress = ({ loaded }) => onBytes(Math.min(loaded, piece.size));
    sending.onloadend = () => {
      signal.removeEventListener("abort", stop);
      if (signal.aborted) reject(signal.reason);
      else if (sending.status === 204) resolve(offsetIn(sending.getResponseHeader("Upload-Offset")));
      else reject(refusal(sending));
    };
    sending.send(piece);
  });
}

export async function finishUpload(id: string, signal: AbortSignal): Promise<Upload> {
  return (await (await request(`${address(id)}/finish`, { method: "POST", signal })).json()) as Upload;
}

/** Begin the check of a capture, unless one is running. */
export async function startCheck(capture: string): Promise<CaptureCheck> {
  return (await sendJson("POST", siteUrl("v1/captures/check"), { capture })) as unknown as CaptureCheck;
}

export async function getCheck(capture: string, signal: AbortSignal): Promise<CaptureCheck> {
  const path = siteUrl(`v1/captures/check?capture=${encodeURIComponent(capture)}`);
  return (await getJson(path, signal)) as unknown as CaptureCheck;
}

function refusal(answer: XMLHttpRequest): ApiError {
  if (answer.status === 0) return new ApiError("The server cannot be reached.");
  if (answer.status === 401) dispatchEvent(new Event(KEY_NEEDED));
  let problem: { detail?: string; code?: string; field?: string } = {};
  try {
    problem = JSON.parse(answer.responseText);
  } catch {
    // for example a proxy's page: the status must suffice
  }
  const reason = problem.detail ?? answer.statusText;
  return new ApiError(`The server answered ${answer.status}: ${reason}`, answer.status, problem.code, problem.field);
}

const offsetIn = (header: string | null): number => Number(header ?? Number.NaN);

/** UTF-8 in Base64. */
const base64 = (text: string): string => btoa(String.fromCharCode(...new TextEncoder().encode(text)));
