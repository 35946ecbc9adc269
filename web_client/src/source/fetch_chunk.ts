/** A chunk over HTTP. */

/**
 * The bytes of a chunk; unless told else past every cache, in which a damaged copy may lie.
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

/** The address of a chunk, or page, of a scene whose stream is `ws://host/v1/scenes/{scene}/stream`, with the link that opens both. */
export function chunkUrl(stream: string, id: string): string {
  const { search } = new URL(stream);
  return new URL(`chunks/${id}${search}`, stream).href.replace(/^ws/, "http");
}
