import { describe, expect, it } from "vitest";
import { project } from "../../src/camera/pinhole";
import { projectedIntrinsics } from "../../src/camera/projection";
import { scenePose } from "../../src/xr/eye_camera";
import { motion, rotationOf } from "../../src/xr/similarity";
import { frustum } from "../frustum";

const room = { rotation: rotationOf({ x: 0, y: 0, z: 0, w: 1 }), scale: 1, translation: [0, 0, 0] } as const;
const still = { position: [0, 0, 0], rotation: room.rotation } as const;

describe("an eye's camera", () => {
  it("stands in the scene where it stands in the room, and sees sizes in the scene's units", () => {
    const sceneFromRoom = motion(0.5, 4, [1, 1.6, 2], [10, 20, 30]);
    const pose = scenePose({ position: [1, 1.6, 2], rotation: still.rotation }, sceneFromRoom);
    const camera = projectedIntrinsics(frustum(-0.1, 0.1, -0.1, 0.1), { width: 100, height: 100 }, 0.2);
    const ahead = [10 - 8 * Math.sin(0.5), 20, 30 - 8 * Math.cos(0.5)] as const; // 2 m
    const [x, y, depth] = project(ahead, pose, camera);
    expect(x).toBeCloseTo(50, 6);
    expect(y).toBeCloseTo(50, 6);
    expect(depth).toBeCloseTo(8, 10);
  });
});
