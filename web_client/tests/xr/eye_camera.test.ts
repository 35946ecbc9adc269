import { describe, expect, it } from "vitest";
import { project } from "../../src/camera/pinhole";
import { eyeIntrinsics, scenePose } from "../../src/xr/eye_camera";
import { motion, rotationOf } from "../../src/xr/similarity";

/** A projection as of OpenGL's glFrustum, by columns; edges on the near plane at 0.1. */
function frustum(left: number, right: number, bottom: number, top: number): Float32Array {
  const [near, far] = [0.1, 100];
  // biome-ignore format: a matrix, by columns
  return new Float32Array([
    (2 * near) / (right - left), 0, 0, 0,
    0, (2 * near) / (top - bottom), 0, 0,
    (right + left) / (right - left), (top + bottom) / (top - bottom), -(far + near) / (far - near), -1,
    0, 0, (-2 * far * near) / (far - near), 0,
  ]);
}

/** Where WebGL's pipeline puts a point before an eye at the origin: pixels from the top left. */
function clipped(m: Float32Array, [x, y, z]: readonly [number, number, number], width: number, height: number) {
  const [u, v, , w] = [0, 1, 2, 3].map((i) => m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i]);
  return [((u / w + 1) / 2) * width, ((1 - v / w) / 2) * height];
}

const room = { rotation: rotationOf({ x: 0, y: 0, z: 0, w: 1 }), scale: 1, translation: [0, 0, 0] } as const;
const still = { position: [0, 0, 0], rotation: room.rotation } as const;

describe("an eye's camera", () => {
  it("sees every point where the headset's lopsided projection puts it", () => {
    const projection = frustum(-0.12, 0.07, -0.09, 0.05);
    const camera = eyeIntrinsics(projection, { x: 0, y: 0, width: 300, height: 400 }, 0.05);
    for (const point of [
      [0, 0, -1],
      [0.4, -0.3, -2],
      [-1, 0.2, -3],
    ] as const) {
      const [x, y, depth] = project(point, scenePose(still, room), camera);
      const [u, v] = clipped(projection, point, 300, 400);
      expect(x).toBeCloseTo(u, 4);
      expect(y).toBeCloseTo(v, 4);
      expect(depth).toBeCloseTo(-point[2], 10);
    }
  });

  it("stands in the scene where it stands in the room, and sees sizes in the scene's units", () => {
    const sceneFromRoom = motion(0.5, 4, [1, 1.6, 2], [10, 20, 30]);
    const pose = scenePose({ position: [1, 1.6, 2], rotation: still.rotation }, sceneFromRoom);
    const camera = eyeIntrinsics(frustum(-0.1, 0.1, -0.1, 0.1), { x: 0, y: 0, width: 100, height: 100 }, 0.2);
    const ahead = [10 - 8 * Math.sin(0.5), 20, 30 - 8 * Math.cos(0.5)] as const; // 2 m
    const [x, y, depth] = project(ahead, pose, camera);
    expect(x).toBeCloseTo(50, 6);
    expect(y).toBeCloseTo(50, 6);
    expect(depth).toBeCloseTo(8, 10);
  });
});
