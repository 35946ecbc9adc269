/** The sound of a scene as its manifest lists it (docs/format.md, "Sound"). It is read only when it is played. */

import { Field } from "./manifest";

export interface SoundPiece {
  /** SHA-256, hex. */
  readonly id: string;
  /** Seconds on the scene's clock; the last decoded sample ends at `end`. */
  readonly start: number;
  readonly end: number;
}

export interface AudioEntry {
  readonly codec: string;
  readonly sampleRate: number;
  readonly channels: number;
  /** In order of time; each piece ends where the next one begins. */
  readonly pieces: readonly SoundPiece[];
}

/**
 * Read a manifest's `audio`.
 *
 * @param inPages whether the list of pieces may be empty: later pages add them.
 * @throws ManifestError
 */
export function readAudio(json: unknown, inPages = false): AudioEntry {
  const root = new Field("audio", json);
  const sizes = new Map<string, number>();
  let before = Number.NEGATIVE_INFINITY;
  const listed = root.get("pieces");
  const pieces = (inPages ? listed.items() : listed.some()).map((field) => {
    const id = field.get("id").hash();
    const bytes = field.get("bytes").whole(1, 2 ** 28);
    if ((sizes.get(id) ?? bytes) !== bytes) throw field.get("bytes").error("as many as of the equal piece before");
    sizes.set(id, bytes);
    const start = field.get("start").number();
    if (start <= before) throw field.get("start").error("later than the one before");
    before = start;
    const end = field.get("end").number();
    if (end <= start) throw field.get("end").error("later than the start");
    return { id, start, end };
  });
  return {
    codec: root.get("codec").text(),
    sampleRate: root.get("sample_rate").whole(1, 1e6),
    channels: root.get("channels").whole(1, 255),
    pieces,
  };
}
