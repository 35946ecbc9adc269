import { expect, it } from "vitest";
import { startCamera } from "../../src/camera/start";
import type { ManifestCamera } from "../../src/codec/types";
import { manifest } from "../scene";

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
