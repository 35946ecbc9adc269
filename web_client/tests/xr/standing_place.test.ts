import { describe, expect, it } from "vitest";
import { poseAt } from "../../src/camera/pinhole";
import type { Mat3, Vec3 } from "../../src/camera/vector";
import { transformed, yawRotation } from "../../src/xr/similarity";
import { standingHere, standingPlace } from "../../src/xr/standing_place";

const close = (a: Vec3, b: Vec3) => {
  for (const i of [0, 1, 2]) expect(a[i]).toBeCloseTo(b[i], 10);
};
const scene = { up: [0, -1, 0], extent: 5, metresPerUnit: null } as const; // taken for two units to a metre
const [c, s] = [Math.cos(0.4), Math.sin(0.4)];
/** Looks along z and 0.4 down (y points down). */
const tilted: Mat3 = [1, 0, 0, 0, c, -s, 0, s, c];

describe("the standing place", () => {
  it("puts the eyes of somebody who stands there where the camera was", () => {
    close(transformed(standingPlace(poseAt([1, 2, 3], tilted), scene, 1.6), [0, 1.6, 0]), [1, 2, 3]);
    close(transformed(standingPlace(poseAt([1, 2, 3], tilted), scene, 0), [0, 0, 0]), [1, 2, 3]);
  });

  it("is as large as the scene says it is", () => {
    const place = standingPlace(poseAt([1, 2, 3], tilted), { ...scene, metresPerUnit: 0.1 }, 0);
    close(transformed(place, [0, 1, 0]), [1, -8, 3]); // a metre up
  });

  it("keeps the scene upright and ahead, although the camera looked down, and nothing mirrored", () => {
    const place = standingPlace(poseAt([1, 2, 3], tilted), scene, 0);
    close(transformed(place, [0, 1, 0]), [1, 0, 3]); // a metre up
    close(transformed(place, [0, 0, -1]), [1, 2, 5]); // ahead
    close(transformed(place, [1, 0, 0]), [3, 2, 3]); // to the right, as in the camera's picture
  });

  it("takes the top of the picture for ahead where the camera looked straight down", () => {
    const down = poseAt([0, 0, 0], [1, 0, 0, 0, 0, -1, 0, 1, 0]); // its picture's top is towards z
    close(transformed(standingPlace(down, scene, 0), [0, 0, -1]), [0, 0, 2]);
  });

  it("comes to where somebody stands by now, before them", () => {
    const first = standingPlace(poseAt([1, 2, 3], tilted), scene, 1.6);
    const head = { position: [4, 1.5, -2], rotation: yawRotation(Math.PI / 2) } as const; // looks to where x falls
    const here = standingHere(first, head);
    close(transformed(here, [4, 1.6, -2]), [1, 2, 3]);
    close(transformed(here, [3, 1.6, -2]), transformed(first, [0, 1.6, -1])); // a metre ahead
    const same = standingHere(first, { position: [0, 1.7, 0], rotation: yawRotation(0) });
    close(transformed(same, [1, 2, 3]), transformed(first, [1, 2, 3]));
  });
});
