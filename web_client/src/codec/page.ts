/** A page of a manifest: whole segments of it, column by column (docs/format.md, "Index and pages"). */

import { ManifestError } from "./errors";
import { toHex } from "./hex";
import type { ChunkEntry, SegmentEntry, SliceEntry } from "./types";

const MAGIC = 0x50534748; // "HGSP"
const HEADER = 6; // numbers of four bytes
const ID = 32; // bytes

/** A piece of sound as a manifest lists it. */
export interface PieceEntry extends SegmentEntry {
  readonly id: string;
  readonly bytes: number;
}

export interface Page {
  readonly segments: readonly SegmentEntry[];
  /** `segment` counts from the page's first. */
  readonly slices: readonly SliceEntry[];
  readonly pieces: readonly PieceEntry[];
}

/**
 * Read a page.
 *
 * @throws ManifestError if the bytes are no page, or damaged.
 */
export async function readPage(bytes: Uint8Array<ArrayBuffer>): Promise<Page> {
  try {
    return unpack(await gunzip(bytes));
  } catch (error) {
    throw error instanceof ManifestError ? error : new ManifestError("page", `is damaged: ${error}`);
  }
}

function unpack(raw: ArrayBuffer): Page {
  const [magic, segmentCount, sliceCount, chunkCount, needCount, pieceCount] = new Uint32Array(raw, 0, HEADER);
  if (magic !== MAGIC) throw new ManifestError("page", "is none");
  let at = 4 * HEADER;
  const column = <Column extends { readonly byteLength: number }>(
    kind: new (raw: ArrayBuffer, at: number, count: number) => Column,
    count: number,
  ): Column => {
    const found = new kind(raw, at, count); // RangeError if there are fewer
    at += found.byteLength;
    return found;
  };
  const spans = (count: number): SegmentEntry[] => {
    const [starts, ends] = [column(Float64Array, count), column(Float64Array, count)];
    return Array.from(starts, (start, i) => ({ start, end: ends[i] }));
  };
  const wholes = (count: number): Uint32Array => column(Uint32Array, count);
  const [segments, times, sounds] = [spans(segmentCount), spans(sliceCount), spans(pieceCount)];
  const boxes = column(Float32Array, 6 * chunkCount);
  const slicesOf = wholes(segmentCount);
  const [chunksOf, needsOf, needs] = [wholes(sliceCount), wholes(sliceCount), wholes(needCount)];
  const [sizes, splats, soundSizes] = [wholes(chunkCount), wholes(chunkCount), wholes(pieceCount)];
  const ids = Array.from({ length: chunkCount + pieceCount }, () => toHex(column(Uint8Array, ID)));

  const corner = (i: number) => [boxes[i], boxes[i + 1], boxes[i + 2]] as const;
  const chunks = Array.from(sizes, (bytes, i): ChunkEntry => {
    return { id: ids[i], bytes, splats: splats[i], box: { min: corner(6 * i), max: corner(6 * i + 3) } };
  });
  const slices: SliceEntry[] = [];
  let [chunk, need] = [0, 0];
  for (const [segment, count] of slicesOf.entries()) {
    for (const time of times.slice(slices.length, slices.length + count)) {
      const i = slices.length;
      const needed = Array.from(needs.subarray(need, need + needsOf[i]), (place) => ids[place]);
      slices.push({ segment, ...time, chunks: chunks.slice(chunk, chunk + chunksOf[i]), needs: needed });
      chunk += chunksOf[i];
      need += needsOf[i];
    }
  }
  if (slices.length !== sliceCount || chunk !== chunkCount || need !== needCount || needs.some((i) => i >= chunkCount))
    throw new ManifestError("page", "contradicts itself");
  return {
    segments,
    slices,
    pieces: sounds.map((time, i) => ({ id: ids[chunkCount + i], bytes: soundSizes[i], ...time })),
  };
}

/** Undo gzip with the browser's own decoder; rejects with TypeError if the bytes are damaged or not gzip. */
export const gunzip = (bytes: Uint8Array<ArrayBuffer>): Promise<ArrayBuffer> =>
  new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
