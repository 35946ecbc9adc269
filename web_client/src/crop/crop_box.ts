/** An upright box in the world of a scene: its faces, its corners, and its forms as an edit. */

import {
  add,
  cross,
  dot,
  fromRows,
  length,
  type Mat3,
  normalise,
  rotateAbout,
  row,
  scale,
  subtract,
  type Vec3,
} from "../camera/vector";

export interface CropBox {
  /** World units. */
  readonly center: Vec3;
  /** Full lengths along its own axes: width, height, depth; above 0. */
  readonly size: Vec3;
  /** Its axes in the world, as rows: right, down, and away. */
  readonly axes: Mat3;
}

/** A face of the box: an axis, and an end of it. */
export interface Face {
  readonly axis: 0 | 1 | 2;
  readonly end: 1 | -1;
}

export const FACES: readonly Face[] = ([0, 1, 2] as const).flatMap((axis) => [
  { axis, end: 1 as const },
  { axis, end: -1 as const },
]);

/** The smallest side, as a share of the largest: a face cannot pass its opposite. */
const THINNEST = 0.01;

/** An upright box of equal sides in the direction of a view. */
export function uprightBox(center: Vec3, side: number, up: Vec3, ahead: Vec3): CropBox {
  const down = scale(normalise(up), -1);
  const across = cross(down, normalise(ahead));
  const some = Math.abs(down[0]) < 0.9 ? ([1, 0, 0] as const) : ([0, 0, 1] as const); // a vertical view: any direction
  const right = normalise(length(across) > 1e-6 ? across : cross(down, some));
  return { center, size: [side, side, side], axes: fromRows(right, down, cross(right, down)) };
}

export const outwards = (box: CropBox, { axis, end }: Face): Vec3 => scale(row(box.axes, axis), end);

export const middleOf = (box: CropBox, face: Face): Vec3 =>
  add(box.center, scale(outwards(box, face), box.size[face.axis] / 2));

/** The eight corners: bit i of a corner's number is its end of axis i. */
export function corners(box: CropBox): Vec3[] {
  return Array.from({ length: 8 }, (_, number) => {
    let corner = box.center;
    for (const axis of [0, 1, 2] as const) {
      const end = (number >> axis) & 1 ? 0.5 : -0.5;
      corner = add(corner, scale(row(box.axes, axis), end * box.size[axis]));
    }
    return corner;
  });
}

/** The twelve edges as pairs of corners, each with its two faces. */
export const EDGES: readonly { readonly ends: readonly [number, number]; readonly faces: readonly [Face, Face] }[] = (
  [0, 1, 2] as const
).flatMap((along) => {
  const [a, b] = ([0, 1, 2] as const).filter((axis) => axis !== along) as [0 | 1 | 2, 0 | 1 | 2];
  return [0, 1, 2, 3].map((k) => {
    const [i, j] = [k & 1, k >> 1];
    const from = (i << a) | (j << b);
    const faces = [
      { axis: a, end: i ? 1 : -1 },
      { axis: b, end: j ? 1 : -1 },
    ] as const;
    return { ends: [from, from | (1 << along)] as const, faces };
  });
});

/** Whether an eye sees the outside of a face. */
export const faces = (box: CropBox, face: Face, eye: Vec3): boolean =>
  dot(subtract(eye, middleOf(box, face)), outwards(box, face)) > 0;

/** Sine of the smallest angle between a face's direction and the eye's for a usable handle. */
const END_ON = 0.16;

/** Whether a face is seen so straight that a motion along its axis would be invisible. */
export function seenEndOn(box: CropBox, face: Face, eye: Vec3): boolean {
  const ray = normalise(subtract(eye, middleOf(box, face)));
  return length(cross(ray, outwards(box, face))) < END_ON;
}

/** The box with one face moved outwards; the opposite one stays. */
export function withFaceMoved(box: CropBox, face: Face, by: number): CropBox {
  const smallest = THINNEST * Math.max(...box.size);
  const moved = Math.max(by, smallest - box.size[face.axis]);
  const size = box.size.map((side, axis) => (axis === face.axis ? side + moved : side)) as unknown as Vec3;
  return { ...box, size, center: add(box.center, scale(outwards(box, face), moved / 2)) };
}

/** The box after a turn about its upright axis, radians, counter-clockwise seen from above. */
export function turned(box: CropBox, angle: number): CropBox {
  const up = scale(row(box.axes, 1), -1);
  const [x, y, z] = ([0, 1, 2] as const).map((axis) => rotateAbout(row(box.axes, axis), up, angle)) as [
    Vec3,
    Vec3,
    Vec3,
  ];
  return { ...box, axes: fromRows(x, y, z) };
}

/** The unit quaternion w, x, y, z, with w at least 0, from the box's axes to the world's: its axes are columns. */
export function quaternionOf({ axes }: CropBox): readonly [number, number, number, number] {
  const at = (column: 0 | 1 | 2, line: 0 | 1 | 2) => axes[3 * column + line] as number;
  const squares = [
    1 + at(0, 0) + at(1, 1) + at(2, 2),
    1 + at(0, 0) - at(1, 1) - at(2, 2),
    1 - at(0, 0) + at(1, 1) - at(2, 2),
    1 - at(0, 0) - at(1, 1) + at(2, 2),
  ];
  const most = squares.indexOf(Math.max(...squares)); // largest part; the others follow from it
  const [wx, wy, wz] = [at(1, 2) - at(2, 1), at(2, 0) - at(0, 2), at(0, 1) - at(1, 0)];
  const [xy, xz, yz] = [at(0, 1) + at(1, 0), at(0, 2) + at(2, 0), at(1, 2) + at(2, 1)];
  const rows = [
    [squares[0], wx, wy, wz],
    [wx, squares[1], xy, xz],
    [wy, xy, squares[2], yz],
    [wz, xz, yz, squares[3]],
  ] as [number, number, number, number][];
  const found = rows[most] as [number, number, number, number];
  const size = Math.hypot(...found) * (found[0] < 0 ? -1 : 1);
  return found.map((part) => part / size) as unknown as [number, number, number, number];
}

/** A requested crop. */
export interface CropWish {
  readonly box: CropBox;
  /** Whether to keep the outside. */
  readonly inverse: boolean;
  /** Seconds of the scene's clock; null for all of it. */
  readonly trim: readonly [number, number] | null;
}

/** The command line for cropping a run. */
export function commandFor({ box, inverse, trim }: CropWish): string {
  const precise = (value: number) => String(Number(value.toPrecision(5)));
  const numbers = [...box.center, ...box.size, ...quaternionOf(box)].map(precise);
  const options = [`--box=${numbers.join(",")}`];
  if (inverse) options.push("--inverse");
  if (trim) options.push(`--trim=${trim.map((time) => String(Number(time.toFixed(3)))).join(",")}`);
  return `hgs edit RUN --out NEW ${options.join(" ")}`;
}

/** The document of an edit that crops a scene (docs/editing.md). */
export function documentFor({ box, inverse, trim }: CropWish): string {
  const numbers = [...box.center, ...box.size, ...quaternionOf(box)];
  return JSON.stringify({ format: "hgs-crop", version: 1, box: numbers, inverse, ...(trim && { trim }) });
}
