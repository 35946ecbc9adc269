import { describe, expect, it } from "vitest";
import { carry } from "../../src/camera/limited_orbit";
import { OrbitCamera } from "../../src/camera/orbit";
import { eyeOf, poseAt, project } from "../../src/camera/pinhole";
import { cross, dot, length, row, type Vec3 } from "../../src/camera/vector";

const UP: Vec3 = [0, -1, 0]; // OpenCV world: y points down
const START = poseAt([0, 0, -4], [1, 0, 0, 0, 1, 0, 0, 0, 1]);
const LENS = { width: 100, height: 100, fx: 100, fy: 100, cx: 50, cy: 50, near: 0.1 };
const orbit = () => new OrbitCamera(START, [0, 0, 0], UP);

describe("OrbitCamera", () => {
  it("starts exactly at the given pose, even off the target", () => {
    const camera = new OrbitCamera(START, [1, 2, 3], UP);
    expect(camera.pose.rotation).toEqual(START.rotation);
    camera.pose.translation.forEach((v, i) => {
      expect(v).toBeCloseTo(START.translation[i]);
    });
  });

  it("moves to its left with positive yaw and keeps looking at the target", () => {
    const camera = orbit();
    camera.turn(Math.PI / 2, 0);
    const [x, y, z] = camera.eye;
    expect(x).toBeCloseTo(-4);
    expect(y).toBeCloseTo(0);
    expect(z).toBeCloseTo(0);
    expect(row(camera.pose.rotation, 2)[0]).toBeCloseTo(1);
  });

  it("moves up with positive pitch", () => {
    const camera = orbit();
    camera.turn(0, 0.5);
    expect(dot(camera.eye, UP)).toBeCloseTo(4 * Math.sin(0.5));
  });

  it("never turns past a pole", () => {
    const camera = orbit();
    for (let i = 0; i < 20; i++) camera.turn(0, 0.5);
    expect(dot(camera.eye, UP)).toBeLessThan(4);
    expect(dot(row(camera.pose.rotation, 1), UP)).toBeLessThan(0);
  });

  it("stays a right-handed rotation after many turns", () => {
    const camera = orbit();
    for (let i = 0; i < 1000; i++) camera.turn(0.1, i % 2 ? 0.05 : -0.05);
    const r = camera.pose.rotation;
    expect(length(row(r, 0))).toBeCloseTo(1);
    expect(dot(row(r, 0), row(r, 1))).toBeCloseTo(0);
    cross(row(r, 0), row(r, 1)).forEach((v, i) => {
      expect(v).toBeCloseTo(row(r, 2)[i]);
    });
    expect(dot(row(r, 0), UP)).toBeCloseTo(0); // level
  });

  it("zooms within limits", () => {
    const camera = orbit();
    camera.zoom(0.5);
    expect(camera.distance).toBeCloseTo(2);
    expect(camera.closeness).toBeCloseTo(0.5);
    camera.zoom(1e-9);
    expect(camera.distance).toBeGreaterThan(0);
  });

  it("pans so that the target follows the drag", () => {
    const camera = orbit();
    camera.pan(100, 50, 400);
    // 100 px to the right at focal 400 and distance 4 is 1 unit: the camera moves left and up.
    expect(camera.eye[0]).toBeCloseTo(-1);
    expect(camera.eye[1]).toBeCloseTo(-0.5);
  });
});

describe("a camera that is placed", () => {
  it("stands there, looks at the target and has up upwards", () => {
    const camera = orbit();
    camera.place([3, -2, 1], [0.5, 0, 0.25], [0.1, -2, 0]);
    expect(eyeOf(camera.pose).map((x) => x.toFixed(6))).toEqual(["3.000000", "-2.000000", "1.000000"]);
    const pinhole = { width: 200, height: 100, fx: 90, fy: 90, cx: 100, cy: 50, near: 0.1 };
    const [x, y, depth] = project([0.5, 0, 0.25], camera.pose, pinhole);
    expect([x, y, depth]).toEqual([expect.closeTo(100), expect.closeTo(50), expect.closeTo(Math.hypot(2.5, 2, 0.75))]);
    const [above, higher] = project([0.6, -2, 0.25], camera.pose, pinhole);
    expect(above).toBeCloseTo(100);
    expect(higher).toBeLessThan(50);
  });

  it("comes back to where it was told to have been", () => {
    const camera = orbit();
    camera.turn(0.4, 0.3);
    camera.pan(20, 10, 300);
    const { pose, eye, target, upwards } = camera;
    camera.turn(1, -0.2);
    camera.place(eye, target, upwards);
    for (const [i, value] of pose.rotation.entries()) expect(camera.pose.rotation[i]).toBeCloseTo(value, 12);
    for (const [i, value] of pose.translation.entries()) expect(camera.pose.translation[i]).toBeCloseTo(value, 12);
  });

  it("needs a direction", () => {
    const camera = orbit();
    expect(() => camera.place([0, 0, 0], [0, 1, 0], [0, -1, 0])).toThrow(RangeError);
    expect(() => camera.place([0, 0, 0], [0, 0, 0], [0, -1, 0])).toThrow(RangeError);
  });

  it("looks around without leaving its place, to its left and upwards", () => {
    const camera = orbit();
    camera.lookAround(0.3, 0.2);
    camera.eye.forEach((value, i) => {
      expect(value).toBeCloseTo(START.translation[i] * -1);
    });
    const forward = row(camera.pose.rotation, 2);
    expect(forward[0]).toBeLessThan(-0.2);
    expect(dot(forward, UP)).toBeCloseTo(Math.sin(0.2));
  });

  it("travels along its own right, the scene's up and its view, in shares of the first distance", () => {
    const camera = orbit();
    camera.travel(0.25, 0.5, 0.75);
    expect(camera.eye.map((value) => Math.round(1e9 * value) / 1e9)).toEqual([1, -2, -1]);
    expect(camera.pose.rotation).toEqual(START.rotation);
  });

  it("is carried around a centre with all that it sees", () => {
    const camera = orbit();
    camera.travel(0.1, 0, 0); // looks past the centre
    const before = project([0, 0, 0], camera.pose, LENS);
    carry(camera, [0, 0, 0], 0.4, 0.3, 1);
    project([0, 0, 0], camera.pose, LENS).forEach((value, i) => {
      expect(value).toBeCloseTo(before[i]);
    });
    expect(dot(camera.eye, UP)).toBeCloseTo(Math.hypot(4, 0.4) * Math.sin(0.3));
    carry(camera, [0, 0, 0], 0, 0, 2);
    expect(length(camera.eye)).toBeCloseTo(2 * Math.hypot(4, 0.4));
  });
});
