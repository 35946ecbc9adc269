import { describe, expect, it, vi } from "vitest";
import { orbitPoseOf } from "../../src/camera/captured_space";
import { LimitedOrbit } from "../../src/camera/limited_orbit";
import { OrbitCamera } from "../../src/camera/orbit";
import { poseAt } from "../../src/camera/pinhole";
import type { Vec3 } from "../../src/camera/vector";
import type { CapturedSpace } from "../../src/codec/types";

const UP: Vec3 = [0, -1, 0];
const START = poseAt([0, 0, -4], [1, 0, 0, 0, 1, 0, 0, 0, 1]);
const CENTER: Vec3 = [0, 0, 0];
const ARC: CapturedSpace = { front: [0, 0, -1], azimuth: 0.5, elevation: [-0.3, 0.4], distance: [2, 6] };
const GIVE = 0.2; // of the rubber band, radians

const limited = (space: CapturedSpace | null = ARC) =>
  new LimitedOrbit(new OrbitCamera(START, CENTER, UP), CENTER, space);
const poseOf = (orbit: LimitedOrbit) => orbitPoseOf(orbit.camera.eye, { center: CENTER, up: UP, front: ARC.front });

/** Drag in small steps, as a hand does. */
function drag(orbit: LimitedOrbit, change: (camera: OrbitCamera) => void, steps = 100): void {
  for (let i = 0; i < steps; i++) orbit.move(change);
}

function letGo(orbit: LimitedOrbit): void {
  for (let i = 0; i < 200; i++) orbit.springBack(1 / 60);
}

/** The higher, the nearer: far away nobody saw what is around. */
const SEEN = {
  elevation: [
    [-0.3, 0.4],
    [-0.3, 0.4],
  ],
  distance: [
    [
      [2, 6],
      [2, 3],
    ],
    [
      [2, 6],
      [2, 3],
    ],
  ],
};

describe("an orbit camera in the captured space", () => {
  it("moves freely inside: bit for bit as one without limits", () => {
    const [bound, free] = [limited(), limited(null)];
    for (const orbit of [bound, free]) drag(orbit, (camera) => camera.turn(0.003, 0.003));
    expect(bound.camera.pose).toEqual(free.camera.pose);
    expect(bound.beyond).toBe(false);
  });

  it.each([
    [1, "azimuth", -0.5],
    [-1, "azimuth", 0.5],
  ] as const)("follows a quarter turn (%s) no farther than the rubber band, and springs back", (side, name, border) => {
    const orbit = limited();
    drag(orbit, (camera) => camera.turn((side * Math.PI) / 200, 0));
    expect(Math.abs(poseOf(orbit)[name])).toBeGreaterThan(0.55);
    expect(Math.abs(poseOf(orbit)[name])).toBeLessThan(0.5 + GIVE);
    expect(orbit.beyond).toBe(true);
    letGo(orbit);
    expect(poseOf(orbit)[name]).toBeCloseTo(border);
    expect(orbit.beyond).toBe(false);
  });

  it("ends softly above and below, near and far", () => {
    const orbit = limited();
    drag(orbit, (camera) => camera.turn(0, 0.02));
    letGo(orbit);
    expect(poseOf(orbit).elevation).toBeCloseTo(0.4);
    drag(orbit, (camera) => camera.turn(0, -0.02));
    letGo(orbit);
    expect(poseOf(orbit).elevation).toBeCloseTo(-0.3);
    drag(orbit, (camera) => camera.zoom(1.05));
    expect(poseOf(orbit).distance).toBeLessThan(6 * 1.5);
    letGo(orbit);
    expect(poseOf(orbit).distance).toBeCloseTo(6);
    drag(orbit, (camera) => camera.zoom(0.95));
    letGo(orbit);
    expect(poseOf(orbit).distance).toBeCloseTo(2);
  });

  it("holds a camera that flies or is panned out", () => {
    const flying = limited();
    drag(flying, (camera) => camera.travel(0, 0, -0.05));
    letGo(flying);
    expect(poseOf(flying).distance).toBeCloseTo(6);
    const panned = limited();
    drag(panned, (camera) => camera.pan(-10, 0, 100));
    letGo(panned);
    expect(Math.abs(poseOf(panned).azimuth)).toBeLessThanOrEqual(0.5 + 1e-6);
  });

  it("pulls the same whether a drag comes in many steps or in one", () => {
    const [many, one] = [limited(), limited()];
    drag(many, (camera) => camera.turn(0.01, 0), 90);
    one.move((camera) => camera.turn(0.9, 0));
    expect(poseOf(many).azimuth).toBeCloseTo(poseOf(one).azimuth);
  });

  it("never jumps to the other border behind the scene", () => {
    const orbit = limited({ ...ARC, azimuth: 3.1 });
    drag(orbit, (camera) => camera.turn(-0.04, 0));
    letGo(orbit);
    expect(poseOf(orbit).azimuth).toBeCloseTo(3.1);
  });

  it("is free where no space is known", () => {
    const orbit = limited(null);
    drag(orbit, (camera) => camera.turn(0.02, 0), 157);
    expect(orbit.camera.eye[2]).toBeCloseTo(4, 1);
    expect(orbit.beyond).toBe(false);
  });

  it("glides along a border that follows what was seen, and rests on it", () => {
    const orbit = limited({ ...ARC, seen: SEEN });
    drag(orbit, (camera) => camera.turn(0, 0.01));
    const steps: number[] = [];
    for (let i = 0; i < 100; i++) {
      const before = poseOf(orbit).distance;
      orbit.springBack(1 / 60);
      steps.push(Math.abs(poseOf(orbit).distance - before));
    }
    letGo(orbit);
    expect(poseOf(orbit).elevation).toBeCloseTo(0.4);
    expect(poseOf(orbit).distance).toBeCloseTo(3);
    expect(Math.max(...steps)).toBeLessThan(0.2);
    expect(orbit.beyond).toBe(false);
  });

  it("stays in the space as it is where what was seen is told wrongly, and says so", () => {
    const warn = vi.spyOn(console, "warn").mockImplementation(() => undefined);
    const orbit = limited({ ...ARC, seen: { ...SEEN, distance: "far" } });
    expect(String(warn.mock.calls)).toContain("captured_space.seen.distance");
    drag(orbit, (camera) => camera.turn(0, 0.02));
    letGo(orbit);
    expect(poseOf(orbit).elevation).toBeCloseTo(0.4);
    expect(poseOf(orbit).distance).toBeCloseTo(4);
    warn.mockRestore();
  });
});
