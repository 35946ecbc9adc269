import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { azimuths, distances, elevations, readSeenLimits } from "../../src/camera/seen_limits";
import { ManifestError } from "../../src/codec/errors";
import type { CapturedSpace } from "../../src/codec/types";

interface Case {
  readonly at: readonly (string | number)[];
  readonly value: unknown;
  readonly field: string;
}

const read = (name: string) =>
  JSON.parse(readFileSync(new URL(`../../../tests/vectors/${name}.json`, import.meta.url), "utf8"));
const INVALID: Case[] = read("invalid_seen");
/** A space of the shared vectors with limits, anew. */
const arc = (): CapturedSpace & { seen: Record<string, unknown> } =>
  read("captured_space").find(
    ({ captured_space: { azimuth, seen } }: { captured_space: CapturedSpace }) => seen && azimuth,
  ).captured_space;

describe("readSeenLimits", () => {
  it("has none where the document has none", () => {
    expect(readSeenLimits({ ...arc(), seen: undefined })).toBeNull();
  });

  it("reads every field", () => {
    const { seen } = arc();
    expect(readSeenLimits(arc())).toEqual({
      azimuth: seen.azimuth,
      elevations: seen.elevation,
      distances: seen.distance,
    });
  });

  it.each(INVALID)("names $field when it is $value", ({ at, value, field }) => {
    const space = arc();
    // biome-ignore lint/suspicious/noExplicitAny: a way into JSON
    const parent = at.slice(0, -1).reduce((node: any, key) => node[key], space.seen);
    const last = at[at.length - 1];
    if (value === null) delete parent[last];
    else parent[last] = value;
    expect(() => readSeenLimits(space)).toThrow(ManifestError);
    expect(() => readSeenLimits(space)).toThrow(`captured_space.${field}`);
  });

  it("refuses ends of a space that is open all round", () => {
    expect(() => readSeenLimits({ ...arc(), azimuth: null })).toThrow("seen.azimuth: is [-0.68,0.5], expected none");
  });
});

describe("limits without what was seen", () => {
  const { seen: _, ...space } = arc();

  it("are those of the space", () => {
    expect(azimuths(space)).toEqual([-0.7, 0.7]);
    expect(elevations(space, 0.3)).toEqual(space.elevation);
    expect(distances(space, 0.3, 0.1)).toEqual(space.distance);
  });

  it("have no end all round", () => {
    expect(azimuths({ ...space, azimuth: null })).toEqual([Number.NEGATIVE_INFINITY, Number.POSITIVE_INFINITY]);
  });
});

describe("limits on the grid", () => {
  const limits = {
    azimuth: null,
    elevations: [
      [-0.2, 0],
      [-0.1, 0.2],
    ],
    distances: [
      [
        [1, 2],
        [1.5, 2],
      ],
      [
        [1, 1.4],
        [1, 2.2],
      ],
    ],
  } as const;
  const space: CapturedSpace = { front: [1, 0, 0], azimuth: 1, elevation: [-0.2, 0.2], distance: [1, 2.5] };

  it("lie between those of its nodes", () => {
    const [low, high] = elevations({ ...space, limits }, 0.5);
    expect([low, high]).toEqual([expect.closeTo(-0.125), expect.closeTo(0.15)]);
    const [nearest, farthest] = distances({ ...space, limits }, 0.5, 0.1);
    expect(nearest).toBeCloseTo(0.25 * 1.375 + 0.75 * 1);
    expect(farthest).toBeCloseTo(0.25 * 2 + 0.75 * 2);
  });

  it("go on round after a whole turn", () => {
    const around = { ...space, azimuth: null, limits };
    for (const azimuth of [-9, -0.1, 0.1, 4, 9]) {
      const [a, b] = [elevations(around, azimuth), elevations(around, azimuth + 2 * Math.PI)];
      for (const end of [0, 1] as const) expect(a[end]).toBeCloseTo(b[end]);
    }
    expect(elevations(around, Math.PI)).toEqual(limits.elevations[1]);
  });
});
