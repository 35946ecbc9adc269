/** Which chunks a playhead needs first, for a source that asks for each by itself. */

import { chunksOf, sliceAt } from "../codec/slices";
import type { ChunkEntry, Manifest } from "../codec/types";
import type { Playhead } from "./scene_source";

/** Slices are to be here so long before they are shown, seconds: a line is not always as fast as it was. */
const MARGIN = 2;

/** The chunks without which there is no picture at a time: the first static one, and those of the slice that is shown. */
export function chunksOfPicture({ static: stills, slices }: Manifest, time: number): ReadonlySet<string> {
  const slice = slices[sliceAt(slices, time)];
  return new Set([...stills.slice(0, 1).map((chunk) => chunk.id), ...(slice ? chunksOf(slice) : [])]);
}

/** A slice and its dynamic chunks that are not here. */
interface Stretch {
  readonly chunks: ChunkEntry[];
  readonly bytes: number;
  /** Seconds until it is shown; infinite while the scene stands. */
  readonly due: number;
}

/**
 * The chunks that are not here, in the order in which they should come.
 *
 * The first static chunk and then the slice at the playhead make a picture. The slices that follow come in turn with the
 * other static chunks, or later if the line brings them in time all the same.
 *
 * @param bytesPerSecond what the line brings.
 * @param here whether a chunk is here, or cannot be had.
 */
export function* chunkOrder(
  manifest: Manifest,
  { time, rate }: Playhead,
  bytesPerSecond: number,
  here: (id: string) => boolean,
): Generator<ChunkEntry> {
  const stills = manifest.static.filter((chunk) => !here(chunk.id));
  if (stills[0]?.id === manifest.static[0]?.id) yield* stills.splice(0, 1);
  let coming = 0; // bytes
  const still = () => stills[0]?.bytes ?? 0;
  for (const { chunks, bytes, due } of stretches(manifest, time ?? manifest.start, rate, here)) {
    while (stills.length > 0 && (coming + still() + bytes) / bytesPerSecond < due - MARGIN) {
      coming += still();
      yield* stills.splice(0, 1);
    }
    yield* chunks;
    coming += bytes + still();
    yield* stills.splice(0, 1);
  }
  yield* stills;
}

/** The slices from the playhead on, around the end, with what is missing of each and of none before. */
function* stretches(
  { slices, start, end }: Manifest,
  time: number,
  rate: number,
  here: (id: string) => boolean,
): Generator<Stretch> {
  const entries = new Map(slices.flatMap((slice) => slice.chunks.map((chunk) => [chunk.id, chunk] as const)));
  const first = sliceAt(slices, time);
  const asked = new Set<string>();
  for (let i = 0; i < slices.length; i++) {
    const slice = slices[(first + i) % slices.length];
    const ids = chunksOf(slice).filter((id) => !here(id) && !asked.has(id));
    for (const id of ids) asked.add(id);
    const chunks = ids.flatMap((id) => entries.get(id) ?? []);
    const wait = slice.start - time + (first + i < slices.length ? 0 : end - start);
    const due = i === 0 ? 0 : rate > 0 ? wait / rate : Number.POSITIVE_INFINITY;
    yield { chunks, bytes: chunks.reduce((sum, chunk) => sum + chunk.bytes, 0), due };
  }
}
