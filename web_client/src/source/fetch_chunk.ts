/** Chunks over HTTP. */

/**
 * The bytes of a chunk; by default not from caches, which may hold a damaged copy.
 *
 * @throws Error with one line for people
 */
export async function fetchChunk(
  url: string,
  signal: AbortSignal,
  cache: "reload" | "default" = "reload",
): Promise<Uint8Array<ArrayBuffer>> {
  let response: Response;
  try {
    response = await fetch(url, { signal, cache });
    if (response.ok) return new Uint8Array(await response.arrayBuffer());
  } catch {
    throw new Error("The server cannot be reached.");
  }
  throw new Error(`The server answered ${response.status}: ${response.statusText}`);
}

/**
 * The address of a chunk, or page, of the scene with the stream `ws://host/v1/scenes/{scene}/stream`, with the stream's
 * link.
 */
export function chunkUrl(stream: string, id: string): string {
  const { search } = new URL(stream);
  return new URL(`chunks/${id}${search}`, stream).href.replace(/^ws/, "http");
}
