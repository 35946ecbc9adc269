/**
 * Limits of a captured space by the views of its cameras, on a grid of azimuths, the columns, and elevations, the rows
 * (docs/format.md, "Seen limits").
 */

import { Field } from "../codec/manifest";
import type { CapturedSpace } from "../codec/types";

/** Lowest and highest. */
export type Range = readonly [number, number];

export interface SeenLimits {
  /** Null: as in the space. */
  readonly azimuth: Range | null;
  /** Ranges of the columns. */
  readonly elevations: readonly Range[];
  /** Ranges of the columns, row by row. */
  readonly distances: readonly (readonly Range[])[];
}

type Space = CapturedSpace & { readonly limits?: SeenLimits | null };

/** Fewest and most columns, and rows. */
const NODES = [2, 64] as const;

/** Null where the document has none. Throws ManifestError. */
export function readSeenLimits({ azimuth, elevation, distance, seen }: CapturedSpace): SeenLimits | null {
  if (seen === undefined) return null;
  const root = new Field("manifest.captured_space.seen", seen);
  const sides = root.given("azimuth");
  if (sides && azimuth === null) throw sides.error("none, as the space is open all round");
  const elevations = nodes(root.get("elevation")).map((field) => inside(field, elevation));
  const columns = root.get("distance").items(elevations.length);
  const distances = columns.map((column) => nodes(column).map((field) => inside(field, distance)));
  for (const [i, { length }] of distances.entries()) {
    if (length !== distances[0].length) throw columns[i].error(`a list of ${distances[0].length}`);
  }
  return { azimuth: sides ? inside(sides, [-(azimuth ?? 0), azimuth ?? 0]) : null, elevations, distances };
}

/** Endless all round. */
export function azimuths({ azimuth, limits }: Space): Range {
  if (azimuth === null) return [Number.NEGATIVE_INFINITY, Number.POSITIVE_INFINITY];
  return limits?.azimuth ?? [-azimuth, azimuth];
}

export function elevations({ azimuth: half, elevation, limits }: Space, azimuth: number): Range {
  if (!limits) return elevation;
  const [first, second, share] = columns(azimuth, half, limits.elevations.length);
  return mixed(limits.elevations[first], limits.elevations[second], share);
}

export function distances(space: Space, azimuth: number, elevation: number): Range {
  const { limits } = space;
  if (!limits) return space.distance;
  const [low, high] = space.elevation;
  const [first, second, share] = columns(azimuth, space.azimuth, limits.distances.length);
  const [row, part] = place(high > low ? (elevation - low) / (high - low) : 0, limits.distances[0].length);
  const at = (column: number) => mixed(limits.distances[column][row], limits.distances[column][row + 1], part);
  return mixed(at(first), at(second), share);
}

function nodes(field: Field): Field[] {
  const items = field.items();
  if (items.length < NODES[0] || items.length > NODES[1]) throw field.error(`${NODES[0]} to ${NODES[1]} entries`);
  return items;
}

function inside(field: Field, [low, high]: Range): Range {
  const range = field.range();
  if (range[0] < low || range[1] > high) throw field.error(`numbers from ${low} to ${high}, the captured space`);
  return range;
}

/** The columns on either side of an azimuth, and how near it is to the second. */
function columns(azimuth: number, half: number | null, count: number): [number, number, number] {
  if (half !== null) {
    const [first, share] = place((azimuth / half + 1) / 2, count);
    return [first, first + 1, share];
  }
  const turn = (azimuth / (2 * Math.PI)) * count;
  const first = Math.floor(turn);
  const around = (column: number) => ((column % count) + count) % count;
  return [around(first), around(first + 1), turn - first];
}

/** The node before a part of the way along a line of them, and its share of the way to the next. */
function place(part: number, count: number): [number, number] {
  const at = Math.min(Math.max(part, 0), 1) * (count - 1);
  const first = Math.min(Math.floor(at), count - 2);
  return [first, at - first];
}

function mixed([low, high]: Range, other: Range, share: number): Range {
  return [low + (other[0] - low) * share, high + (other[1] - high) * share];
}
