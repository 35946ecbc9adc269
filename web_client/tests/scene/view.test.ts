import { describe, expect, it } from "vitest";
import { poseAt, project } from "../../src/camera/pinhole";
import { apply, fromRows, type Mat3, rotateAbout, type Vec3 } from "../../src/camera/vector";
import { headSight } from "../../src/scene/head_sight";
import { sameView, sightOf, type View } from "../../src/scene/view";

const HEAD: Vec3 = [0.3, -1.6, 2.5];
const camera = { width: 100, height: 100, fx: 50, fy: 50, cx: 50, cy: 50, near: 0.05 };

const turned = (angle: number): Mat3 => {
  const turn = (v: Vec3) => rotateAbout(v, [0, 1, 0], angle);
  return fromRows(turn([1, 0, 0]), turn([0, 1, 0]), turn([0, 0, 1]));
};

/** The two eyes of a head about its middle. */
function eyes(angle: number): [View, View] {
  const rotation = turned(angle);
  const eye = (side: number): View => {
    const [x, y, z] = [rotation[0] * side, rotation[1] * side, rotation[2] * side];
    return { pose: poseAt([HEAD[0] + x, HEAD[1] + y, HEAD[2] + z], rotation), camera };
  };
  return [eye(-0.032), eye(0.032)];
}

describe("sightOf", () => {
  it("is a single view's depth along its axis", () => {
    const rotation = turned(0.7);
    const pose = poseAt(HEAD, rotation);
    const { depth } = sightOf([{ pose, camera }]);
    const point: Vec3 = [2, 0.5, -1];
    if (depth.kind !== "planar") throw new Error(depth.kind);
    const along = depth.x * point[0] + depth.y * point[1] + depth.z * point[2] + depth.offset;
    expect(along).toBeCloseTo(project(point, pose, camera)[2], 6);
    expect(along).toBeCloseTo(apply(rotation, [2 - HEAD[0], 0.5 - HEAD[1], -1 - HEAD[2]])[2], 6);
    expect(depth.near).toBe(0.05);
  });
});

describe("headSight", () => {
  it("is the distance from the middle of a head's eyes, whichever way it looks", () => {
    for (const angle of [0, 0.4, 3]) {
      const { kind, x, y, z } = headSight(eyes(angle)).depth;
      expect(kind).toBe("radial");
      [x, y, z].forEach((value, i) => {
        expect(value).toBeCloseTo(HEAD[i], 6);
      });
    }
  });

  it("keeps splats all around a head, and those that a single view may show", () => {
    expect(headSight(eyes(0)).frustum).toBeNull();
    expect(sightOf([eyes(0)[0]]).frustum).toHaveLength(4);
  });

  it("leaves out nothing that either eye could see", () => {
    expect(headSight(eyes(1)).depth.near).toBeCloseTo(0.05 - 0.032, 6);
  });
});

describe("sameView", () => {
  const view: View = {
    pose: { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [0, 0, 0] },
    camera: { width: 8, height: 8, fx: 8, fy: 8, cx: 4, cy: 4, near: 0.01 },
    clear: 1,
  };

  it("is true of a copy", () => {
    expect(sameView(view, structuredClone(view))).toBe(true);
  });

  it("is false where other things fade, and from another place", () => {
    expect(sameView(view, { ...view, clear: 2 })).toBe(false);
    expect(sameView(view, { ...view, still: 0 })).toBe(false);
    expect(sameView(view, { ...view, pose: { ...view.pose, translation: [0, 0, 1] } })).toBe(false);
  });
});
