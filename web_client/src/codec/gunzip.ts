/** Undoes gzip, as every browser can by itself; rejects with TypeError where the bytes are something else, or damaged. */
export const gunzip = (bytes: Uint8Array<ArrayBuffer>): Promise<ArrayBuffer> =>
  new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
