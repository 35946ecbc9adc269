/** The hello of a connection: the client's chunks, playhead and requests. */

import { fromHex } from "../codec/hex";
import { type ClientMessage, MOST_HAVE, MOST_PARTS, PROTOCOL } from "../protocol/messages";
import type { PartialChunks } from "../protocol/partial_chunks";
import type { Playhead } from "./scene_source";
import type { StreamedSound } from "./streamed_sound";

/** The state of a stream when it connects. */
export interface StreamState {
  readonly playhead: Playhead;
  /** SHA-256 of the index; null before the first. */
  readonly id: Uint8Array | null;
  /** The received pages, with the ids that they list. */
  readonly pages: readonly (readonly [string, readonly string[]])[];
  readonly sound: Pick<StreamedSound, "wanted" | "sent">;
  /** Ids of complete chunks. */
  readonly have: ReadonlySet<string>;
  /** Incomplete chunks; only as many are kept as a hello may list. */
  readonly partial: PartialChunks;
}

/**
 * The hello for a state.
 *
 * @param credits bytes that the server may send.
 */
export function helloOf(
  credits: number,
  { playhead: { time, rate }, id, pages, sound, have, partial }: StreamState,
): Extract<ClientMessage, { type: "hello" }> {
  const here = new Set([...(sound.wanted ? sound.sent : []), ...have]);
  const listed = new Set(pages.flatMap(([page, ids]) => [page, ...ids]));
  const others = [...here].filter((name) => !listed.has(name)).slice(-MOST_HAVE);
  return {
    type: "hello",
    protocol: PROTOCOL,
    credits,
    ...(others.length > 0 && { have: others.map(fromHex) }),
    ...(pages.length > 0 && { pages: pages.map(([page, ids]) => [fromHex(page), bitsOf(ids, here)]) }),
    parts: partial.keep(MOST_PARTS).map(([id, filled]) => [fromHex(id), filled]),
    ...(id && { manifest_id: id }),
    ...(time !== null && { time }),
    rate,
    ...(sound.wanted && { audio: true }),
    follow: true,
  };
}

/** A bit field of the present names, lowest bits first. */
function bitsOf(names: readonly string[], there: ReadonlySet<string>): Uint8Array {
  const bits = new Uint8Array(Math.ceil(names.length / 8));
  for (const [i, name] of names.entries()) if (there.has(name)) bits[i >> 3] |= 1 << (i & 7);
  return bits;
}
