import { type Camera, Matrix4, Object3D, OrthographicCamera, PerspectiveCamera, Quaternion, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { pixelToClip, project } from "../../src/camera/pinhole";
import { hostView } from "../../src/host/host_view";
import { threePicture } from "../../src/three/three_camera";

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

const seenBy = (eye: Camera, place: Matrix4) => hostView(threePicture(eye, place, VIEWPORT), VIEWPORT);

describe("the view of a scene in a host's world", () => {
  it.each([
    ["plain", camera()],
    ["lopsided", lopsided()],
  ])("puts splats where three.js puts points: %s", (_, eye) => {
    const { view } = seenBy(eye, world());
    const [x, y] = project(POINT, view.pose, view.camera);
    const expected = projected(eye);
    expect(pixelToClip(x, y, VIEWPORT)[0]).toBeCloseTo(expected.x, 9);
    expect(pixelToClip(x, y, VIEWPORT)[1]).toBeCloseTo(expected.y, 9);
  });

  it("gives splats the depth that three.js gives points", () => {
    const eye = camera();
    const { view, depth } = seenBy(eye, world());
    const r = view.pose.rotation;
    const p = [0, 3, 6].map((i, row) => POINT.reduce((sum, v, k) => sum + r[i + k] * v, view.pose.translation[row]));
    const by = (row: readonly number[]) => row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3];
    expect(by(depth.z) / by(depth.w)).toBeCloseTo(projected(eye).z, 9);
  });

  it("turns the host's near distance into the scene's units", () => {
    expect(seenBy(camera(), world()).view.camera.near).toBeCloseTo(0.2 / 1.7, 9);
  });

  it("refuses cameras without perspective", () => {
    const flat = new OrthographicCamera();
    flat.name = "map";
    expect(() => seenBy(flat, world())).toThrow("the camera map has no perspective");
  });

  it.each([
    ["more than one scale", [1, 2, 1], "1, 2, 1"],
    ["a mirror", [-1, 1, 1], "1, 1, 1"],
    ["nothing", [0, 0, 0], "0, 0, 0"],
  ])("refuses %s", (_, [x, y, z], words) => {
    const matrix = new Matrix4().makeScale(x, y, z);
    expect(() => seenBy(camera(), matrix)).toThrow(`the scene is scaled by ${words}`);
  });

  it("refuses what a turned child of a stretched parent becomes", () => {
    const [parent, child] = [new Object3D(), new Object3D()];
    parent.scale.set(1, 3, 1);
    child.rotation.z = 0.5;
    parent.add(child);
    parent.updateMatrixWorld();
    expect(() => seenBy(camera(), child.matrixWorld)).toThrow("one positive scale for all axes");
  });
});
