import { describe, expect, it } from "vitest";
import { dot, normalise, type Vec3 } from "../../src/camera/vector";
import type { RoomPose } from "../../src/xr/eye_camera";
import type { Panorama } from "../../src/xr/panorama";
import { type Similarity, yawRotation } from "../../src/xr/similarity";
import { tooLittle, WayBack } from "../../src/xr/way_back";

/** Directions all round, covered where they are within `radius`, radians, of `middle`. */
function scene(radius: number, middle: Vec3 = [0, 0, -1]): Panorama {
  const steps = Array.from({ length: 41 }, (_, i) => i / 20 - 1);
  return steps.flatMap((x) =>
    steps.flatMap((y) =>
      [-1, 1].map((z) => {
        const direction = normalise([x, y, z]);
        const alpha = dot(direction, middle) > Math.cos(radius) ? 1 : 0;
        return { direction, size: 1, light: [alpha, alpha, alpha] as const, alpha };
      }),
    ),
  );
}

const AHEAD: Vec3 = [0, 0, -1];
const BEHIND: Vec3 = [0, 0, 1];
const SAME: Similarity = { rotation: yawRotation(0), scale: 1, translation: [0, 0, 0] };
const head = (yaw: number): RoomPose => ({ position: [0, 0, 0], rotation: yawRotation(yaw) });

describe("who looks", () => {
  it("at the scene, or past half of it, sees enough", () => {
    expect(tooLittle(scene(0.5), AHEAD, AHEAD)).toBe(false);
    expect(tooLittle(scene(0.5), normalise([1, 0, -1]), AHEAD)).toBe(false);
  });

  it("away from it has lost it", () => {
    expect(tooLittle(scene(0.5), BEHIND, AHEAD)).toBe(true);
  });

  it("at a small scene has not lost it", () => {
    expect(tooLittle(scene(0.15), AHEAD, AHEAD)).toBe(false);
    expect(tooLittle(scene(0.15), BEHIND, AHEAD)).toBe(true);
  });

  it("anywhere in a scene that is all round has not lost it", () => {
    expect(tooLittle(scene(Math.PI), BEHIND, AHEAD)).toBe(false);
  });

  it("at nothing has lost it", () => {
    expect(tooLittle(scene(0), AHEAD, AHEAD)).toBe(true);
  });
});

describe("the way back", () => {
  it("is shown to who has seen nothing for a second, and until the scene is seen", () => {
    const way = new WayBack([0, 0, -3]);
    const lost = (yaw: number, now: number) => way.update(scene(0.5), head(yaw), SAME, now);
    expect(lost(0, 0)).toBe(false);
    expect(lost(Math.PI, 500)).toBe(false);
    expect(lost(Math.PI, 900)).toBe(false);
    expect(lost(Math.PI, 1001)).toBe(true);
    expect(lost(0, 1100)).toBe(false);
  });

  it("is not shown before it is known what there is to see", () => {
    const way = new WayBack([0, 0, -3]);
    way.update(null, head(Math.PI), SAME, 0);
    expect(way.update(null, head(Math.PI), SAME, 5000)).toBe(false);
  });

  it.each([
    [Math.PI / 2, 1], // turned to the left: the scene is on the right
    [-Math.PI / 2, -1],
    [Math.PI - 0.1, 1],
    [Math.PI + 0.1, -1],
  ])("points to the side on which the scene is, to who has turned by %d", (yaw, side) => {
    const way = new WayBack([0, 0, -3]);
    const at = head(yaw);
    way.update(scene(0.5), at, SAME, 0);
    const quads = way.arrow(at, [0, 0, 0]);
    expect(quads).toHaveLength(2);
    const right: Vec3 = [at.rotation[0], at.rotation[3], at.rotation[6]];
    for (const { corner, up } of quads) {
      expect(Math.sign(dot(corner, right))).toBe(side);
      expect(Math.sign(dot(up, right))).toBe(side); // from the wings to the tip
    }
  });

  it("is no arrow where the scene is ahead, and up where that is above", () => {
    const way = new WayBack([0, 3, 0]);
    way.update(scene(0.5), head(0), SAME, 0);
    expect(way.arrow(head(0), [0, 0, 0]).every(({ up }) => up[1] > 0)).toBe(true);
    const ahead = new WayBack([0, 0, -3]);
    ahead.update(scene(0.5), head(0), SAME, 0);
    expect(ahead.arrow(head(0), [0, 0, 0])).toEqual([]);
  });

  it("is as long as the room is large", () => {
    const twice: Similarity = { ...SAME, scale: 2 };
    expect(new WayBack([0, 0, -3]).distance([0, 0, 0], twice)).toBe(1.5);
  });
});
