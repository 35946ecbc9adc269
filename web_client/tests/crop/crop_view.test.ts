import { describe, expect, it } from "vitest";
import { poseAt } from "../../src/camera/pinhole";
import { add, fromRows, length, scale, subtract, type Vec3 } from "../../src/camera/vector";
import { alongLine, type CropView, onPlane, type Pixel, rayThrough, seenAt, seenLine } from "../../src/crop/crop_view";

const VIEW: CropView = {
  pose: poseAt([1, 2, -5], fromRows([1, 0, 0], [0, 1, 0], [0, 0, 1])),
  camera: { width: 800, height: 600, fx: 500, fy: 510, cx: 390, cy: 310, near: 0.2 },
  eye: [1, 2, -5],
};

describe("a view of a box", () => {
  it("sends a ray through each place to the points that are seen there", () => {
    const point: Vec3 = [-0.4, 3.1, 2];
    const ray = rayThrough(seenAt(point, VIEW) as Pixel, VIEW);
    const along = length(subtract(point, VIEW.eye));
    expect(length(subtract(add(VIEW.eye, scale(ray, along)), point))).toBeLessThan(1e-9);
  });

  it("finds points of lines and planes where they are seen", () => {
    const [origin, direction]: [Vec3, Vec3] = [
      [0, 1, 1],
      [0.6, 0, 0.8],
    ];
    const seen = seenAt(add(origin, scale(direction, 1.7)), VIEW) as Pixel;
    expect(alongLine(origin, direction, seen, VIEW)).toBeCloseTo(1.7);
    const place: Vec3 = [2, 3, 4];
    const found = onPlane([0, 0, 4], [0, 0, 1], seenAt(place, VIEW) as Pixel, VIEW) as Vec3;
    expect(length(subtract(found, place))).toBeLessThan(1e-9);
    expect(onPlane([0, 2, 0], [0, 1, 0], [390, 310], VIEW)).toBeNull(); // from its edge
    expect(onPlane([0, 0, -9], [0, 0, 1], [390, 310], VIEW)).toBeNull(); // behind the eye
  });

  it("cuts a line where it goes behind the eye", () => {
    const ahead: Vec3 = [1, 3, 0];
    const [from, to] = seenLine(ahead, [1, 3, -9], VIEW) as [Pixel, Pixel];
    expect(from).toEqual(seenAt(ahead, VIEW));
    expect(to[0]).toBeCloseTo(390);
    expect(to[1]).toBeGreaterThan(5000);
    expect(seenLine([0, 0, -6], [0, 0, -7], VIEW)).toBeNull();
    expect(seenAt([0, 0, -6], VIEW)).toBeNull();
  });
});
