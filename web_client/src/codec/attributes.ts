/** The attributes a chunk can hold (docs/format.md, "Attributes"). */

import type { Container, Stream } from "./chunk";
import { ChunkError } from "./errors";

export const TRANSFORM = { none: 0, delta: 1, chain: 2 } as const;

/** The bit of a form for splats with a changing rotation. The two bits below it hold the order of motion. */
export const TURNS = 4;

/** The bit of a form for motions of order 3 that continue to the fifth order. */
export const FIFTH = 8;

export interface Attribute {
  readonly id: number;
  readonly name: AttributeName;
  readonly components: number;
  /** The three codes interleaved, stored as differences of the ascending Morton codes. */
  readonly morton: boolean;
  /** The highest transform number that the attribute may have. */
  readonly lastTransform: number;
  readonly dynamicOnly: boolean;
  /** Order of motion, TURNS or FIFTH, required for a row; 0 if every splat has one. */
  readonly rowsOf: number;
  /** First version of the format with this attribute. */
  readonly version: number;
}

/** Whether a splat of this form has a row of the attribute. */
export const hasRow = ({ rowsOf }: Attribute, form: number): boolean =>
  rowsOf === TURNS || rowsOf === FIFTH ? (form & rowsOf) !== 0 : (form & 3) >= rowsOf;

export type AttributeName =
  | "position"
  | "log_scale"
  | "rotation"
  | "opacity"
  | "rgb"
  | "time_center"
  | "time_log_precision"
  | "form"
  | "velocity"
  | "acceleration"
  | "jerk"
  | "snap"
  | "crackle"
  | "turning";

function attribute(
  id: number,
  name: AttributeName,
  components: number,
  lastTransform: number = TRANSFORM.delta,
  rowsOf = 0,
): Attribute {
  const version = rowsOf === FIFTH ? 3 : 2;
  return { id, name, components, morton: name === "position", lastTransform, dynamicOnly: id >= 16, rowsOf, version };
}

export const ATTRIBUTES: readonly Attribute[] = [
  attribute(1, "position", 3, TRANSFORM.none),
  attribute(2, "log_scale", 3, TRANSFORM.chain),
  attribute(3, "rotation", 3),
  attribute(4, "opacity", 1),
  attribute(5, "rgb", 3, TRANSFORM.chain),
  attribute(16, "time_center", 1),
  attribute(17, "time_log_precision", 1),
  attribute(18, "form", 1),
  attribute(19, "velocity", 3, TRANSFORM.delta, 1),
  attribute(20, "acceleration", 3, TRANSFORM.delta, 2),
  attribute(21, "jerk", 3, TRANSFORM.delta, 3),
  attribute(22, "turning", 4, TRANSFORM.delta, TURNS),
  attribute(23, "snap", 3, TRANSFORM.delta, FIFTH),
  attribute(24, "crackle", 3, TRANSFORM.delta, FIFTH),
];

export function attributeOf(name: AttributeName): Attribute {
  return ATTRIBUTES.find((attribute) => attribute.name === name) as Attribute;
}

/** Bytes per row of an attribute of `bits` before compression. */
export function planesOf(attribute: Attribute, bits: number): number {
  return attribute.morton ? Math.ceil((3 * bits) / 8) : attribute.components * Math.ceil(bits / 8);
}

const MAX_BITS = 24;

export type Streams = ReadonlyMap<AttributeName, Stream>;

/** The streams of known attributes, their table entries checked. Throws ChunkError. */
export function knownStreams({ version, kind, streams }: Container): Streams {
  const known = new Map<AttributeName, Stream>();
  for (const stream of streams) {
    const attribute = ATTRIBUTES.find(({ id }) => id === stream.attribute);
    if (!attribute || attribute.version > version || (attribute.dynamicOnly && kind === "static")) continue;
    checkEntry(stream, attribute);
    known.set(attribute.name, stream);
  }
  return known;
}

function checkEntry({ at, components, grid, transform, planes }: Stream, attribute: Attribute): void {
  const expect = (condition: boolean, byte: number, field: string, found: unknown, expected: unknown) => {
    if (!condition)
      throw new ChunkError(byte, `attribute ${attribute.id} (${attribute.name}) ${field}`, found, expected);
  };
  const { bits, step } = grid;
  expect(components === attribute.components, at + 1, "components", components, attribute.components);
  expect(bits >= 1 && bits <= MAX_BITS, at + 2, "bits", bits, `1 to ${MAX_BITS}`);
  expect(transform <= attribute.lastTransform, at + 3, "transform", transform, `at most ${attribute.lastTransform}`);
  expect(planes.length === planesOf(attribute, bits), at + 4, "planes", planes.length, planesOf(attribute, bits));
  expect(step > 0 && step < Infinity, at + 5, "step", step, "above 0 and finite");
}
