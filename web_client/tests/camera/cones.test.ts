import { afterEach, describe, expect, it, vi } from "vitest";
import { stillShare } from "../../src/camera/cones";
import { poseAt } from "../../src/camera/pinhole";
import type { Vec3 } from "../../src/camera/vector";
import type { CapturedSpace } from "../../src/codec/types";

const CENTER: Vec3 = [1, 2, 3];
const DEGREE = Math.PI / 180;

/** A direction on the horizon, z upwards, and above it. */
const towards = (azimuth: number, elevation = 0): Vec3 => [
  Math.cos(azimuth * DEGREE) * Math.cos(elevation * DEGREE),
  Math.sin(azimuth * DEGREE) * Math.cos(elevation * DEGREE),
  Math.sin(elevation * DEGREE),
];

const space = (cones?: unknown): CapturedSpace => ({
  front: [1, 0, 0],
  azimuth: null,
  elevation: [-1, 1],
  distance: [1, 9],
  cones,
});

/** The share for an eye at a place around the centre; it looks anywhere. */
function share(cones: unknown, azimuth: number, elevation = 0, distance = 4): number {
  const direction = towards(azimuth, elevation);
  const eye = CENTER.map((c, i) => c + distance * direction[i]) as unknown as Vec3;
  const pose = poseAt(eye, [0, 1, 0, 0, 0, 1, 1, 0, 0]);
  return stillShare({ center: CENTER, capturedSpace: space(cones) })({ pose });
}

const THREE = [0, 120, 240].map((azimuth) => towards(azimuth));

afterEach(() => vi.restoreAllMocks());

describe("stillShare", () => {
  // (s^2 (3 - 2 s))^2 with s = 1, 3/4, 1/2, 1/4, 0
  it.each([
    [0, 1],
    [9.9, 1],
    [15, 729 / 1024],
    [20, 1 / 4],
    [25, 25 / 1024],
    [30.1, 0],
    [60, 0],
  ])("is by the angle from the nearest camera: %f degrees", (angle, expected) => {
    for (const azimuth of [0, 120, 240]) {
      for (const side of [-1, 1]) expect(share(THREE, azimuth + side * angle)).toBeCloseTo(expected, 9);
      expect(share(THREE, azimuth, angle)).toBeCloseTo(expected, 9);
    }
  });

  it("is the same at any distance, and 1 in the centre", () => {
    for (const distance of [0.1, 4, 100]) expect(share(THREE, 20, 0, distance)).toBeCloseTo(1 / 4, 9);
    expect(share(THREE, 60, 0, 0)).toBe(1);
  });

  it("is 1 everywhere for a dense rig, and without a captured space", () => {
    for (const azimuth of [0, 60, 77]) expect(share(undefined, azimuth)).toBe(1);
    const pose = poseAt([0, 0, 0], [1, 0, 0, 0, 1, 0, 0, 0, 1]);
    expect(stillShare({ center: CENTER, capturedSpace: null })({ pose })).toBe(1);
  });

  it.each([[7], [[[0, 1]]], [[["a", 0, 0]]]])("is 1 everywhere, with a warning, for invalid cones %j", (cones) => {
    const warn = vi.spyOn(console, "warn").mockImplementation(() => {});
    expect(share(cones, 60)).toBe(1);
    expect(warn).toHaveBeenCalledOnce();
  });
});
