/** The attributes a chunk can hold (docs/format.md, "Attributes"). */

export const TRANSFORM = { none: 0, delta: 1, chain: 2 } as const;

/** The bit of "form" that says that a splat's rotation changes; the two bits below it hold the order of its motion. */
export const TURNS = 4;

export interface Attribute {
  readonly id: number;
  readonly name: AttributeName;
  readonly components: number;
  /** The three codes interleaved, stored as differences of the ascending Morton codes. */
  readonly morton: boolean;
  /** The largest number of a transform it may have. */
  readonly lastTransform: number;
  readonly dynamicOnly: boolean;
  /** Order of motion, or TURNS, that a splat must have to have a row; 0: every splat has one. */
  readonly rowsOf: number;
}

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
  | "turning";

function attribute(
  id: number,
  name: AttributeName,
  components: number,
  lastTransform: number = TRANSFORM.delta,
  rowsOf = 0,
): Attribute {
  return { id, name, components, morton: name === "position", lastTransform, dynamicOnly: id >= 16, rowsOf };
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
];

/** Bytes per row of an attribute of `bits` before compression. */
export function planesOf(attribute: Attribute, bits: number): number {
  return attribute.morton ? Math.ceil((3 * bits) / 8) : attribute.components * Math.ceil(bits / 8);
}
