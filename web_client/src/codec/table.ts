/** What the attribute table of a chunk says of the attributes that this version knows. */

import { ATTRIBUTES, type Attribute, type AttributeName, planesOf } from "./attributes";
import type { Container, Stream } from "./chunk";
import { ChunkError } from "./errors";

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
