import fc from "fast-check";
import { describe, expect, it } from "vitest";
import { add, cross, dot, length, row, scale, subtract, type Vec3 } from "../../src/camera/vector";
import {
  commandFor,
  corners,
  documentFor,
  EDGES,
  FACES,
  faces,
  middleOf,
  quaternionOf,
  seenEndOn,
  turned,
  uprightBox,
  withFaceMoved,
} from "../../src/crop/crop_box";

const BOX = uprightBox([1, 2, 3], 2, [0, -1, 0], [0, 0, 1]);
const number = fc.double({ min: -3, max: 3, noNaN: true });
const vector = fc.tuple(number, number, number).filter((v) => length(v) > 0.1);

/** As docs/numerics.md has it: the matrix of a unit quaternion, whose columns are the turned axes. */
function column([w, x, y, z]: readonly number[], i: 0 | 1 | 2): Vec3 {
  return (
    [
      [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
      [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
      [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
    ] as const
  )[i];
}

describe("a box", () => {
  it("stands upright, right-handed, and looks the way that was asked for", () => {
    fc.assert(
      fc.property(vector, vector, (up, ahead) => {
        const { axes } = uprightBox([0, 0, 0], 1, up, ahead);
        const [x, y, z] = [row(axes, 0), row(axes, 1), row(axes, 2)];
        expect(dot(y, up)).toBeCloseTo(-length(up));
        expect(length(subtract(cross(x, y), z))).toBeLessThan(1e-9);
        expect(dot(z, ahead)).toBeGreaterThanOrEqual(-1e-6 * length(ahead)); // who looks up or down looks nowhere
      }),
    );
  });

  it("has its corners half its sides from the middle", () => {
    expect(corners(BOX)[0]).toEqual([0, 1, 2]);
    expect(corners(BOX)[7]).toEqual([2, 3, 4]);
  });

  it("has twelve edges as long as its sides, each on its two faces", () => {
    const places = corners({ ...BOX, size: [1, 2, 3] });
    const lengths = EDGES.map(({ ends: [a, b] }) => length(subtract(places[a] as Vec3, places[b] as Vec3)));
    expect(lengths.sort()).toEqual([1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3]);
    const square = corners(BOX);
    for (const { ends, faces: meeting } of EDGES) {
      for (const face of meeting) {
        const out = subtract(middleOf(BOX, face), BOX.center);
        for (const end of ends) expect(dot(subtract(square[end] as Vec3, BOX.center), out)).toBeCloseTo(1);
      }
    }
  });

  it("keeps the opposite face where one is moved, and never turns inside out", () => {
    for (const face of FACES) {
      const opposite = { axis: face.axis, end: -face.end as 1 | -1 };
      const larger = withFaceMoved(BOX, face, 0.5);
      expect(middleOf(larger, opposite)).toEqual(middleOf(BOX, opposite));
      expect(larger.size[face.axis]).toBe(2.5);
      expect(withFaceMoved(BOX, face, -9).size[face.axis]).toBeCloseTo(0.02);
    }
  });

  it("shows an eye the faces on its side", () => {
    const seen = FACES.filter((face) => faces(BOX, face, [1, 2, -9]));
    expect(seen).toEqual([{ axis: 2, end: -1 }]);
    expect(seenEndOn(BOX, { axis: 2, end: -1 }, [1, 2.1, -9])).toBe(true);
    expect(seenEndOn(BOX, { axis: 2, end: -1 }, [4, 2, -9])).toBe(false);
  });

  it("turns counter-clockwise seen from above", () => {
    const quarter = turned(BOX, Math.PI / 2);
    const away = row(quarter.axes, 2); // from +z, about -y, to -x
    expect(away.map((x) => Math.round(x) + 0)).toEqual([-1, 0, 0]);
    expect(length(subtract(row(quarter.axes, 1), row(BOX.axes, 1)))).toBe(0);
  });

  it("has the quaternion that takes its axes to the world's", () => {
    fc.assert(
      fc.property(vector, vector, fc.double({ min: -4, max: 4, noNaN: true }), (up, ahead, angle) => {
        const box = turned(uprightBox([0, 0, 0], 1, up, ahead), angle);
        const found = quaternionOf(box);
        expect(Math.hypot(...found)).toBeCloseTo(1);
        expect(found[0]).toBeGreaterThanOrEqual(0);
        for (const i of [0, 1, 2] as const) {
          expect(length(subtract(column(found, i), row(box.axes, i)))).toBeLessThan(1e-7);
        }
      }),
    );
  });
});

describe("the command line", () => {
  it("has the box, and what else is wished", () => {
    expect(commandFor({ box: BOX, inverse: false, trim: null })).toBe(
      "hgs edit RUN --out NEW --box=1,2,3,2,2,2,1,0,0,0",
    );
    const box = { ...BOX, center: add([0, 0, 0], scale([1, 1, 1], 1 / 3)) };
    expect(commandFor({ box, inverse: true, trim: [0.25, 1.00049] })).toBe(
      "hgs edit RUN --out NEW --box=0.33333,0.33333,0.33333,2,2,2,1,0,0,0 --inverse --trim=0.25,1",
    );
  });
});

describe("the document of an edit", () => {
  const read = (wish: Parameters<typeof documentFor>[0]) => JSON.parse(documentFor(wish));

  it("has the box in full precision, and the kept side", () => {
    const box = { ...BOX, center: scale([1, 1, 1], 1 / 3) };
    const numbers = [1 / 3, 1 / 3, 1 / 3, 2, 2, 2, 1, 0, 0, 0];
    expect(read({ box, inverse: true, trim: null })).toEqual({
      format: "hgs-crop",
      version: 1,
      box: numbers,
      inverse: true,
    });
  });

  it("has the repeated stretch", () => {
    expect(read({ box: BOX, inverse: false, trim: [0.25, 59 / 30] }).trim).toEqual([0.25, 59 / 30]);
  });
});
