import { describe, expect, it } from "vitest";
import {
  eyeOf,
  fitted,
  pixelToClip,
  poseAt,
  poseOf,
  project,
  resized,
  startBox,
  startCamera,
} from "../../src/camera/pinhole";
import { apply, type Vec3 } from "../../src/camera/vector";
import type { ManifestCamera } from "../../src/codec/types";
import { unproject } from "../../src/player/glance";
import { manifest } from "../scene";

const CAMERA = { width: 640, height: 360, fx: 500, fy: 510, cx: 330, cy: 170, near: 0.2 };
const FRONT = poseOf([
  [1, 0, 0, 0],
  [0, 1, 0, 0],
  [0, 0, 1, 0],
]);

/** World point -> clip space, as the vertex shader does it. */
const clip = (point: Vec3) => {
  const [x, y] = project(point, FRONT, CAMERA);
  return pixelToClip(x, y, CAMERA);
};

describe("OpenCV world to clip space", () => {
  it("puts a point to the right of the axis on the right", () => {
    expect(clip([1, 0, 5])[0]).toBeGreaterThan(clip([0, 0, 5])[0]);
  });

  it("puts a point below the axis (y down) lower, which is smaller y in clip space", () => {
    expect(clip([0, 1, 5])[1]).toBeLessThan(clip([0, 0, 5])[1]);
  });

  it("puts the picture's corners at the corners of clip space", () => {
    expect(pixelToClip(0, 0, CAMERA)).toEqual([-1, 1]);
    expect(pixelToClip(640, 360, CAMERA)).toEqual([1, -1]);
  });

  it("projects the axis to the principal point", () => {
    expect(project([0, 0, 7], FRONT, CAMERA)).toEqual([330, 170, 7]);
  });
});

describe("poses", () => {
  // Looks along +x with the world's +z up: x right = -y, y down = -z, z forward = x.
  const pose = poseOf([
    [0, -1, 0, 2],
    [0, 0, -1, 3],
    [1, 0, 0, 4],
  ]);

  it("has its eye where the camera's coordinates are zero", () => {
    const eye = eyeOf(pose);
    const local = apply(pose.rotation, eye).map((v, i) => v + pose.translation[i]);
    expect(local).toEqual([0, 0, 0]);
  });

  it("sees at a pixel the point that was projected to it", () => {
    const point: Vec3 = [9, -4, 2];
    unproject(project(point, pose, CAMERA), pose, CAMERA).forEach((value, i) => {
      expect(value).toBeCloseTo(point[i]);
    });
  });

  it("is made again from its eye and rotation", () => {
    const again = poseAt(eyeOf(pose), pose.rotation);
    expect(again.translation).toEqual(pose.translation);
  });
});

describe("picture sizes", () => {
  it("scales each axis alone, as Camera.scaled does", () => {
    expect(resized(CAMERA, 320, 90)).toEqual({
      width: 320,
      height: 90,
      fx: 250,
      fy: 127.5,
      cx: 165,
      cy: 42.5,
      near: 0.2,
    });
  });

  /** Where the edges of the capture's picture lie on a canvas. */
  const edges = (width: number, height: number) => {
    const view = fitted(CAMERA, width, height);
    expect(view.fx / view.fy).toBeCloseTo(500 / 510);
    return {
      left: ((0 - CAMERA.cx) / CAMERA.fx) * view.fx + view.cx,
      right: ((640 - CAMERA.cx) / CAMERA.fx) * view.fx + view.cx,
      top: ((0 - CAMERA.cy) / CAMERA.fy) * view.fy + view.cy,
      bottom: ((360 - CAMERA.cy) / CAMERA.fy) * view.fy + view.cy,
    };
  };

  it.each([
    [390, 844],
    [600, 601],
    [1280, 800],
  ])("covers %s x %s: upright, or little is lost by it", (width, height) => {
    const { left, right, top, bottom } = edges(width, height);
    expect(top).toBeCloseTo(0);
    expect(bottom).toBeCloseTo(height);
    expect(left).toBeLessThanOrEqual(0);
    expect(right).toBeGreaterThanOrEqual(width);
    expect(left + right).toBeCloseTo(width);
  });

  it.each([
    [844, 390],
    [1000, 300],
    [600, 600],
  ])("cuts no more than a sixth of the picture off on %s x %s", (width, height) => {
    const { left, right, top, bottom } = edges(width, height);
    const seen = { across: Math.min(1, width / (right - left)), down: Math.min(1, height / (bottom - top)) };
    expect(Math.min(seen.across, seen.down)).toBeGreaterThan(1 / 1.2 - 1e-9);
    expect(Math.min(seen.across, seen.down)).toBeLessThan(0.9);
    expect(left + right).toBeCloseTo(width);
    expect(top + bottom).toBeCloseTo(height);
  });

  it("shows a picture of the canvas's shape whole", () => {
    expect(edges(1920, 1080)).toEqual({ left: 0, right: 1920, top: 0, bottom: 1080 });
  });
});

const camera = (name: string, x: number): ManifestCamera => ({
  name,
  width: 640,
  height: 360,
  fx: 500,
  fy: 500,
  cx: 320,
  cy: 180,
  near: 0.01,
  worldToCamera: [
    [1, 0, 0, x],
    [0, 1, 0, 0],
    [0, 0, 1, 3],
    [0, 0, 0, 1],
  ],
});
const scene = manifest({ cameras: [camera("a", 1), camera("b", 2)] });

it("takes the named camera, else the first", () => {
  expect(startCamera(scene, "b").pose.translation).toEqual([2, 0, 3]);
  expect(startCamera(scene, null).name).toBe("a");
});

it("names the cameras there are", () => {
  expect(() => startCamera(scene, "c")).toThrow("camera c: the scene has no such camera; there are a, b");
});

describe("the views to begin with", () => {
  const box = [100, 50, 300, 350] as const;
  const started = manifest({
    cameras: scene.cameras,
    startViews: [
      { camera: "b", box },
      { camera: "a", box },
    ],
  });

  it("depend on the canvas's shape, and a name overrules them", () => {
    expect(startCamera(started, null).name).toBe("b");
    expect(startCamera(started, null, true).name).toBe("a");
    expect(startCamera(started, "a").name).toBe("a");
  });

  it("have a box for their own camera alone", () => {
    expect(startBox(started, "b", false)).toEqual(box);
    expect(startBox(started, "b", true)).toBeNull();
    expect(startBox(scene, "a", false)).toBeNull();
  });

  it.each([
    [390, 844],
    [1280, 800],
    [3000, 400],
  ])("keep the box in a canvas of %i x %i", (width, height) => {
    for (const [left, top, right, bottom] of [box, [-50, 20, 200, 600], [500, 100, 700, 200]] as const) {
      const view = fitted(CAMERA, width, height, [left, top, right, bottom]);
      const x = (u: number) => view.cx + (u - CAMERA.cx) * (view.fx / CAMERA.fx);
      const y = (v: number) => view.cy + (v - CAMERA.cy) * (view.fy / CAMERA.fy);
      for (const u of [left, right]) expect(Math.abs(x(u) - width / 2)).toBeLessThan(width / 2 + 1e-6);
      for (const v of [top, bottom]) expect(Math.abs(y(v) - height / 2)).toBeLessThan(height / 2 + 1e-6);
    }
  });

  it("show nothing beside the picture if the box leaves room", () => {
    const view = fitted(CAMERA, 390, 844, [0, 100, 150, 200]);
    expect(view.cx).toBeCloseTo(CAMERA.cx * (view.fx / CAMERA.fx)); // the picture's left edge is the canvas's
  });
});
