import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { readAudio } from "../../src/codec/audio_entry";
import { ManifestError } from "../../src/codec/errors";

interface Case {
  at: (string | number)[];
  value: unknown;
  field: string;
}

const vectors = () =>
  JSON.parse(readFileSync(new URL("../../../tests/vectors/audio.json", import.meta.url), "utf8")) as {
    audio: Record<string, unknown>;
    invalid: Case[];
  };

describe("readAudio", () => {
  it("reads every field", () => {
    const audio = readAudio(vectors().audio);
    expect(audio).toMatchObject({ codec: "opus", sampleRate: 48000, channels: 2 });
    expect(audio.pieces.map(({ start, end }) => [start, end])).toEqual([
      [-0.013, 0.987],
      [0.987, 1.5],
      [1.5, 1.7],
      [1.9, 2.1],
    ]);
    expect(audio.pieces[3].id).toBe(audio.pieces[2].id);
  });

  it.each(vectors().invalid)("names $field when it is $value", ({ at, value, field }) => {
    const { audio } = vectors();
    // biome-ignore lint/suspicious/noExplicitAny: a way into JSON
    const parent = at.slice(0, -1).reduce((node: any, key) => node[key], audio);
    const last = at[at.length - 1];
    if (value === null) delete parent[last];
    else parent[last] = value;
    const read = () => readAudio(audio);
    expect(read).toThrow(ManifestError);
    expect(read).toThrow(field);
  });
});
