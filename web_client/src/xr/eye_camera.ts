/** What an eye of a headset sees, as a camera of this project: OpenCV axes, pixels, world units. */

import { type Intrinsics, type Pose, poseAt } from "../camera/pinhole";
import type { Mat3, Vec3 } from "../camera/vector";
import { multiply, rotationOf, type Similarity, transformed, transpose } from "./similarity";

/** A place and direction in the room: `rotation` takes own axes (x right, y up, z backwards) to the room's. */
export interface RoomPose {
  readonly position: Vec3;
  readonly rotation: Mat3;
}

export interface Viewport {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** WebXR's axes from OpenCV's: y and z the other way. A half turn about x, no mirror. */
const FLIP: Mat3 = [1, 0, 0, 0, -1, 0, 0, 0, -1];

export function roomPose({ position: p, orientation }: XRRigidTransform): RoomPose {
  return { position: [p.x, p.y, p.z], rotation: rotationOf(orientation) };
}

/** The pose in the scene of an eye, or of the head between the eyes, at `pose` in the room. */
export function scenePose(pose: RoomPose, sceneFromRoom: Similarity): Pose {
  const sceneFromCamera = multiply(sceneFromRoom.rotation, multiply(pose.rotation, FLIP));
  return poseAt(transformed(sceneFromRoom, pose.position), transpose(sceneFromCamera));
}

/**
 * The intrinsics of an eye, exactly, however lopsided its picture: `projection` is WebXR's matrix by columns.
 *
 * @param near world units
 */
export function eyeIntrinsics(projection: ArrayLike<number>, { width, height }: Viewport, near: number): Intrinsics {
  return {
    width,
    height,
    fx: (projection[0] * width) / 2,
    fy: (projection[5] * height) / 2,
    cx: ((1 - projection[8]) * width) / 2,
    cy: ((1 + projection[9]) * height) / 2,
    near,
  };
}
