/** Downloads over HTTP, and the delay before another attempt. */

import { ManifestError } from "../codec/errors";

const SILENCE = 10_000; // ms without a byte before a download is given up

/** Error for an answer other than the file. */
export class StatusError extends Error {
  constructor(
    readonly status: number,
    url: string,
  ) {
    super(`${url}: the server answered ${status}`);
  }

  /** Whether the server reports that the file does not exist. */
  get missing(): boolean {
    return this.status === 404 || this.status === 410;
  }
}

export interface Download {
  /** Address of the file, after redirects. */
  readonly url: string;
  readonly bytes: Uint8Array<ArrayBuffer>;
}

/**
 * Fetch a file, of `length` bytes if that is known.
 *
 * @throws StatusError for any answer but 200, ManifestError for a file of another length, and another error if the
 *   server cannot be reached or falls silent.
 */
export async function download(
  url: string,
  signal: AbortSignal,
  cache: RequestCache,
  length?: number,
): Promise<Download> {
  const silence = new AbortController();
  let timer = setTimeout(() => silence.abort(), SILENCE);
  try {
    const response = await fetch(url, { signal: AbortSignal.any([signal, silence.signal]), cache });
    if (response.status !== 200) {
      void response.body?.cancel();
      throw new StatusError(response.status, url);
    }
    const parts: Uint8Array[] = [];
    const reader = response.body?.getReader();
    for (let part = await reader?.read(); part?.value; part = await reader?.read()) {
      parts.push(part.value);
      clearTimeout(timer);
      timer = setTimeout(() => silence.abort(), SILENCE);
    }
    const bytes = joined(parts);
    if (length !== undefined && bytes.length !== length) {
      throw new ManifestError(url, `has ${bytes.length} bytes, expected ${length}`);
    }
    return { url: response.url || url, bytes };
  } finally {
    clearTimeout(timer);
  }
}

function joined(parts: readonly Uint8Array[]): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}

/** Longest wait before the first retry, ms; doubled at each failure. */
const FIRST_RETRY = 500;
const LAST_RETRY = 8000; // ms

/** Milliseconds, random in a range, so that not all viewers of a restarted server return at once. */
export const retryDelay = (failures: number): number =>
  Math.min(LAST_RETRY, FIRST_RETRY * 2 ** failures) * Math.random();
