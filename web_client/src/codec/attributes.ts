/** The attributes a chunk can hold (docs/format.md, "Attributes"). */

export const QUANTISER = { affine: 0, morton: 1, smallestThree: 2 } as const;

export const TRANSFORM = { none: 0, delta: 1, green: 2 } as const;

export interface Attribute {
  readonly id: number;
  readonly name: AttributeName;
  readonly components: number;
  readonly quantiser: number;
  readonly dynamicOnly: boolean;
}

export type AttributeName =
  | "position"
  | "log_scale"
  | "rotation"
  | "opacity"
  | "rgb"
  | "time_center"
  | "time_log_precision"
  | "time_exponent"
  | "velocity"
  | "acceleration"
  | "jerk"
  | "turning";

function attribute(
  id: number,
  name: AttributeName,
  components: number,
  quantiser: number = QUANTISER.affine,
): Attribute {
  return { id, name, components, quantiser, dynamicOnly: id >= 16 };
}

export const ATTRIBUTES: readonly Attribute[] = [
  attribute(1, "position", 3, QUANTISER.morton),
  attribute(2, "log_scale", 3),
  attribute(3, "rotation", 3, QUANTISER.smallestThree),
  attribute(4, "opacity", 1),
  attribute(5, "rgb", 3),
  attribute(16, "time_center", 1),
  attribute(17, "time_log_precision", 1),
  attribute(18, "time_exponent", 1),
  attribute(19, "velocity", 3),
  attribute(20, "acceleration", 3),
  attribute(21, "jerk", 3),
  attribute(22, "turning", 4),
];

/** Bytes per splat of an attribute of `bits` before compression. */
export function planesOf(attribute: Attribute, bits: number): number {
  if (attribute.quantiser === QUANTISER.morton) return Math.ceil((3 * bits) / 8);
  const planes = attribute.components * Math.ceil(bits / 8);
  return attribute.quantiser === QUANTISER.smallestThree ? planes + 1 : planes;
}
