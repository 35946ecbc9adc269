import { expect, it } from "vitest";
import { eyeOf } from "../../src/camera/pinhole";
import { row, type Vec3 } from "../../src/camera/vector";
import type { Shot } from "../../src/renderer/shot";
import type { SplatDrawer } from "../../src/renderer/splat_drawer";
import { coverage, meanColour, type Panorama, PanoramaCamera } from "../../src/xr/panorama";
import { type Similarity, yawRotation } from "../../src/xr/similarity";
import { fakeCanvas } from "../canvas";

const pose = { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [0, 0, 0] } as const;
const camera = { width: 4, height: 4, fx: 4, fy: 4, cx: 2, cy: 2, near: 0.1 };
const shot: Shot = { pose, camera, time: 0.5, antialiased: true, rig: [] };
const WIDTH = 6 * 24;

/** A panorama where the small picture number `face` shows light in its upper right corner, and what was drawn for it. */
function taken(face: number, sceneFromRoom: Similarity): { panorama: Panorama; shots: Shot[] } {
  const shots: Shot[] = [];
  const readPixels = (...[, , , , , , pixels]: [number, number, number, number, number, number, Uint8Array]) => {
    pixels.fill(255, 4 * (23 * WIDTH + 24 * face + 23), 4 * (23 * WIDTH + 24 * face + 24));
  };
  const gl = fakeCanvas({ readPixels }).getContext("webgl2");
  const splats = { gl, draw: (drawn: Shot) => shots.push(drawn) } as unknown as SplatDrawer;
  const from = new PanoramaCamera([1, 2, 3], sceneFromRoom, splats);
  for (;;) {
    const panorama = from.step(shot);
    if (panorama) return { panorama, shots };
  }
}

const AT: Similarity = { rotation: yawRotation(Math.PI / 2), scale: 2, translation: [5, 0, 0] };

it.each([0, 1, 2, 3, 4, 5])("knows which way it has looked in picture %d", (face) => {
  const { panorama, shots } = taken(face, AT);
  const lit = panorama.filter(({ alpha }) => alpha > 0);
  expect(lit).toHaveLength(1);
  const { rotation } = shots[face].pose; // x to the right, y down, z ahead, in the scene
  const part = (axis: 0 | 1 | 2) => row(rotation, axis).reduce((sum, v, i) => sum + v * lit[0].direction[i], 0);
  expect(part(0) / part(2)).toBeCloseTo(23 / 24, 6);
  expect(part(1) / part(2)).toBeCloseTo(-23 / 24, 6);
});

it("is taken from the head, at the time of the eyes, in all directions", () => {
  const { shots } = taken(0, AT);
  const ahead = shots.map(({ pose: { rotation } }) => row(rotation, 2).map(Math.round).join());
  expect(new Set(ahead).size).toBe(6);
  for (const { pose: from, time } of shots) {
    expect(time).toBe(0.5);
    const eye = eyeOf(from); // (1, 2, 3) turned to the left by a quarter, twice as far, and shifted
    [11, 4, -2].forEach((value, i) => void expect(eye[i]).toBeCloseTo(value, 6));
  }
});

it("covers the whole sphere evenly", () => {
  const { panorama } = taken(0, AT);
  const whole = panorama.map((glimpse) => ({ ...glimpse, alpha: glimpse.direction[1] > 0 ? 1 : 0 }));
  expect(coverage(whole, [0, 1, 0], 0)).toBe(1);
  expect(coverage(whole, [1, 0, 0], -1)).toBeCloseTo(0.5, 3);
  const cap = panorama.map((glimpse) => ({ ...glimpse, alpha: glimpse.direction[2] > 0.5 ? 1 : 0 }));
  expect(coverage(cap, [1, 0, 0], -1)).toBeCloseTo(0.25, 1); // as of a cap of half the radius
});

it("has a mean colour of what it shows, whatever lies open", () => {
  const glimpse = (light: Vec3, alpha: number) => ({ direction: [0, 0, 1] as const, size: 1, light, alpha });
  const { colour, covered } = meanColour([glimpse([0.5, 0.25, 0], 0.5), glimpse([0, 0, 0], 0)], () => 1);
  expect(colour).toEqual([1, 0.5, 0]);
  expect(covered).toBe(0.25);
});
