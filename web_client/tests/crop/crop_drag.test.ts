import { describe, expect, it } from "vitest";
import { poseAt } from "../../src/camera/pinhole";
import { dot, fromRows, length, row, subtract, type Vec3 } from "../../src/camera/vector";
import { FACES, faces, seenEndOn, uprightBox } from "../../src/crop/crop_box";
import { dragged, placeOf } from "../../src/crop/crop_drag";
import { type CropView, type Pixel, seenAt } from "../../src/crop/crop_view";

const BOX = uprightBox([0, 0, 0], 2, [0, -1, 0], [0.3, 0, 1]);
const EYE: Vec3 = [2, -3, -8];

/** An eye that looks along z, tilted down a little: from above and from the side of the box. */
const VIEW: CropView = {
  pose: poseAt(EYE, fromRows([1, 0, 0], [0, 0.94, -0.341174], [0, 0.341174, 0.94])),
  camera: { width: 800, height: 600, fx: 600, fy: 600, cx: 400, cy: 300, near: 0.1 },
  eye: EYE,
};

const moved = ([x, y]: Pixel, dx: number, dy: number): Pixel => [x + dx, y + dy];
const at = (place: Vec3) => seenAt(place, VIEW) as Pixel;

describe("dragging a handle", () => {
  it("keeps a face's handle under the pointer along the face's direction", () => {
    for (const face of FACES.filter((face) => !seenEndOn(BOX, face, EYE))) {
      const from = at(placeOf(face, BOX));
      const nudged = { ...BOX, size: BOX.size.map((side, axis) => (axis === face.axis ? side + 0.02 : side)) as never };
      const [x, y] = at(placeOf(face, nudged));
      const to = moved(from, (x - from[0]) * 30, (y - from[1]) * 30); // some way along the line that it is seen on
      const after = at(placeOf(face, dragged(face, BOX, from, to, VIEW)));
      expect(Math.hypot(after[0] - to[0], after[1] - to[1])).toBeLessThan(8);
    }
  });

  it("moves the whole box with its middle, parallel to the picture", () => {
    const from = at(BOX.center);
    const box = dragged("middle", BOX, from, moved(from, 40, -25), VIEW);
    const after = at(box.center);
    expect(after[0]).toBeCloseTo(from[0] + 40);
    expect(after[1]).toBeCloseTo(from[1] - 25);
    expect(dot(subtract(box.center, BOX.center), row(VIEW.pose.rotation, 2))).toBeCloseTo(0);
    expect([box.size, box.axes]).toEqual([BOX.size, BOX.axes]);
  });

  it("turns the box about its upright axis as far as its handle goes round", () => {
    const from = at(placeOf("turn", BOX));
    const box = dragged("turn", BOX, from, moved(from, 60, 0), VIEW);
    expect(length(subtract(row(box.axes, 1), row(BOX.axes, 1)))).toBe(0);
    expect(dot(row(box.axes, 2), row(BOX.axes, 2))).toBeLessThan(0.999);
    expect(length(subtract(box.center, BOX.center))).toBe(0);
    expect(at(placeOf("turn", box))[0]).toBeGreaterThan(from[0] + 30);
  });

  it("turns the box the same way where its floor is seen from the edge", () => {
    const view = {
      ...VIEW,
      eye: [0, 0.9, -8] as Vec3,
      pose: poseAt([0, 0.9, -8], fromRows([1, 0, 0], [0, 1, 0], [0, 0, 1])),
    };
    const from = seenAt(placeOf("turn", BOX), view) as Pixel;
    const box = dragged("turn", BOX, from, moved(from, 40, 0), view);
    expect((seenAt(placeOf("turn", box), view) as Pixel)[0]).toBeGreaterThan(from[0] + 30);
  });

  it("changes nothing where a line is seen end on", () => {
    const view = {
      ...VIEW,
      eye: [0, 0, -8] as Vec3,
      pose: poseAt([0, 0, -8], fromRows([1, 0, 0], [0, 1, 0], [0, 0, 1])),
    };
    const box = uprightBox([0, 0, 0], 2, [0, -1, 0], [0, 0, 1]);
    const face = { axis: 2, end: -1 } as const;
    expect(faces(box, face, view.eye)).toBe(true);
    expect(dragged(face, box, [400, 300], [400.5, 300], view)).toBe(box);
  });
});
