/** What a client says first on every connection: what it has, where its playhead is, and what it wants. */

import { type ClientMessage, fromHex, MOST_HAVE, MOST_PARTS, PROTOCOL } from "../protocol/messages";
import type { PartialChunks } from "../protocol/partial_chunks";
import type { Playhead } from "./scene_source";
import type { StreamedManifest } from "./streamed_manifest";
import type { StreamedSound } from "./streamed_sound";

/** What a stream has when it connects. */
export interface StreamState {
  readonly playhead: Playhead;
  readonly manifest: Pick<StreamedManifest, "id" | "grows" | "chunks">;
  readonly sound: Pick<StreamedSound, "wanted" | "sent">;
  /** Ids of complete chunks. */
  readonly have: ReadonlySet<string>;
  /** Of these no more are kept than a hello may name. */
  readonly partial: PartialChunks;
}

/** @param credits bytes that the server may send. */
export function helloOf(
  credits: number,
  { playhead: { time, rate }, manifest, sound, have, partial }: StreamState,
): Extract<ClientMessage, { type: "hello" }> {
  const { id, grows, chunks } = manifest; // one that grows may have become another one
  const named = [...(sound.wanted ? sound.sent : []), ...(grows ? have : [])].slice(-MOST_HAVE);
  return {
    type: "hello",
    protocol: PROTOCOL,
    credits,
    ...((grows || sound.wanted) && { have: named.map(fromHex) }),
    have_bits: !grows && chunks.length > 0 ? bitsOf(chunks, have) : undefined,
    codings: ["gzip"],
    parts: partial.keep(MOST_PARTS).map(([id, filled]) => [fromHex(id), filled]),
    ...(id && { manifest_id: id }),
    ...(time !== null && { time }),
    rate,
    ...(sound.wanted && { audio: true }),
    follow: true,
  };
}

/** Which of the names are there, one bit each, lowest bits first. */
function bitsOf(names: readonly string[], there: ReadonlySet<string>): Uint8Array {
  const bits = new Uint8Array(Math.ceil(names.length / 8));
  for (const [i, name] of names.entries()) if (there.has(name)) bits[i >> 3] |= 1 << (i & 7);
  return bits;
}
