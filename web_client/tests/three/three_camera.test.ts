import { Group, Matrix4, PerspectiveCamera, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { apply } from "../../src/camera/vector";
import { capturePlace } from "../../src/host/host_view";
import { placeCamera } from "../../src/three/three_camera";
import { manifest } from "../scene";

// Turned a quarter about z and half a turn about x: the columns of the rotation are not its rows.
const ROWS = [
  [0, 1, 0, 0.5],
  [1, 0, 0, -0.25],
  [0, 0, -1, 4],
  [0, 0, 0, 1],
];
const CAPTURE = { name: "side", width: 400, height: 200, fx: 300, fy: 300, cx: 200, cy: 100, near: 0.1 };
const SCENE = manifest({ cameras: [{ ...CAPTURE, worldToCamera: ROWS }] });
const PLACE = [0.2, 0.3, -0.1] as const;

function looking(aspect: number, parent = new Group()): PerspectiveCamera {
  const world = new Matrix4()
    .makeRotationY(0.4)
    .setPosition(1, 2, 3)
    .scale(new Vector3(2, 2, 2));
  const camera = new PerspectiveCamera(50, aspect, 0.1, 100);
  parent.add(camera);
  parent.updateMatrixWorld();
  placeCamera(camera, world, capturePlace(SCENE, "side", aspect));
  return camera;
}

/** Where a camera sees a point of the scene, in [-1, 1]. */
function seen(camera: PerspectiveCamera): number[] {
  const world = new Matrix4()
    .makeRotationY(0.4)
    .setPosition(1, 2, 3)
    .scale(new Vector3(2, 2, 2));
  return new Vector3(...PLACE).applyMatrix4(world).project(camera).toArray().slice(0, 2);
}

/** The same as the capture's camera sees it. */
function expected(): number[] {
  const [x, y, z] = apply([0, 1, 0, 1, 0, 0, 0, 0, -1], PLACE).map((v, i) => v + ROWS[i][3]);
  return [(300 * x) / z / 200, (-300 * y) / z / 100];
}

describe("a camera put where one of the capture stood", () => {
  it("sees what that one saw", () => {
    seen(looking(2)).forEach((v, i) => {
      expect(v).toBeCloseTo(expected()[i], 9);
    });
  });

  it("stands there whatever it is a child of", () => {
    const parent = new Group();
    parent.position.set(5, -1, 2);
    parent.rotation.set(0.3, 0.8, -0.2);
    seen(looking(2, parent)).forEach((v, i) => {
      expect(v).toBeCloseTo(expected()[i], 9);
    });
  });

  it("sees all of that one's picture on a taller picture, too", () => {
    const [x, y] = seen(looking(1));
    expect(x).toBeCloseTo(expected()[0], 9);
    expect(y).toBeCloseTo(expected()[1] / 2, 9);
  });

  it("is refused for cameras that the capture has not", () => {
    expect(() => capturePlace(SCENE, "roof", 1)).toThrow("there are side");
  });
});
