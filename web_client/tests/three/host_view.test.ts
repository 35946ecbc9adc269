import { Group, Matrix4, Object3D, OrthographicCamera, PerspectiveCamera, Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { pixelToClip, project } from "../../src/camera/pinhole";
import { apply } from "../../src/camera/vector";
import { hostView, lookFrom } from "../../src/three/host_view";
import { manifest } from "../scene";

const VIEWPORT = { x: 7, y: 9, width: 640, height: 360 };
const POINT = [0.3, -0.2, 0.5] as const;

function camera(): PerspectiveCamera {
  const made = new PerspectiveCamera(40, 16 / 9, 0.2, 30);
  made.position.set(1, 2, 6);
  made.lookAt(0.2, 0.1, -0.3);
  made.updateMatrixWorld();
  return made;
}

/** Of a part of a larger picture: its middle is not where the camera looks. */
function lopsided(): PerspectiveCamera {
  const made = camera();
  made.setViewOffset(800, 600, 100, 50, 500, 300);
  return made;
}

function world(): Matrix4 {
  const turn = new Quaternion().setFromAxisAngle(new Vector3(1, 2, -1).normalize(), 1.1);
  return new Matrix4().compose(new Vector3(0.4, -0.3, 0.2), turn, new Vector3(1.7, 1.7, 1.7));
}

/** Where three.js itself projects a point of the scene: normalised device coordinates. */
const projected = (eye: PerspectiveCamera): Vector3 => new Vector3(...POINT).applyMatrix4(world()).project(eye);

describe("the view of a scene in a host's world", () => {
  it.each([
    ["plain", camera()],
    ["lopsided", lopsided()],
  ])("puts splats where three.js puts points: %s", (_, eye) => {
    const { view } = hostView(eye, world(), VIEWPORT);
    const [x, y] = project(POINT, view.pose, view.camera);
    const expected = projected(eye);
    expect(pixelToClip(x, y, VIEWPORT)[0]).toBeCloseTo(expected.x, 9);
    expect(pixelToClip(x, y, VIEWPORT)[1]).toBeCloseTo(expected.y, 9);
  });

  it("gives splats the depth that three.js gives points", () => {
    const eye = camera();
    const { view, depth } = hostView(eye, world(), VIEWPORT);
    const r = view.pose.rotation;
    const p = [0, 3, 6].map((i, row) => POINT.reduce((sum, v, k) => sum + r[i + k] * v, view.pose.translation[row]));
    const by = (row: readonly number[]) => row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
    expect(by(depth.z) / by(depth.w)).toBeCloseTo(projected(eye).z, 9);
  });

  it("turns the host's near distance into the scene's units", () => {
    expect(hostView(camera(), world(), VIEWPORT).view.camera.near).toBeCloseTo(0.2 / 1.7, 9);
  });

  it("refuses cameras without perspective", () => {
    const flat = new OrthographicCamera();
    flat.name = "map";
    expect(() => hostView(flat, world(), VIEWPORT)).toThrow("the camera map has no perspective");
  });

  it.each([
    ["more than one scale", [1, 2, 1], "1, 2, 1"],
    ["a mirror", [-1, 1, 1], "1, 1, 1"],
    ["nothing", [0, 0, 0], "0, 0, 0"],
  ])("refuses %s", (_, [x, y, z], words) => {
    const matrix = new Matrix4().makeScale(x, y, z);
    expect(() => hostView(camera(), matrix, VIEWPORT)).toThrow(`the scene is scaled by ${words}`);
  });

  it("refuses what a turned child of a stretched parent becomes", () => {
    const [parent, child] = [new Object3D(), new Object3D()];
    parent.scale.set(1, 3, 1);
    child.rotation.z = 0.5;
    parent.add(child);
    parent.updateMatrixWorld();
    expect(() => hostView(camera(), child.matrixWorld, VIEWPORT)).toThrow("one positive scale for all axes");
  });
});

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
  lookFrom(camera, world, SCENE, "side");
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
    expect(() => lookFrom(new PerspectiveCamera(), new Matrix4(), SCENE, "roof")).toThrow("there are side");
  });
});
