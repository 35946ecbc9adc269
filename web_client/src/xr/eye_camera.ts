/** The eye of a headset as a camera of this project: OpenCV axes, world units. */

import { type Pose, poseAt } from "../camera/pinhole";
import type { Mat3, Vec3 } from "../camera/vector";
import { multiply, rotationOf, type Similarity, transformed, transpose } from "./similarity";

/** A pose in the room: `rotation` takes own axes (x right, y up, z backwards) to the room's. */
export interface RoomPose {
  readonly position: Vec3;
  readonly rotation: Mat3;
}

/** WebXR's axes from OpenCV's: y and z inverted. A half turn about x, no mirror. */
const FLIP: Mat3 = [1, 0, 0, 0, -1, 0, 0, 0, -1];

export function roomPose({ position: p, orientation }: XRRigidTransform): RoomPose {
  return { position: [p.x, p.y, p.z], rotation: rotationOf(orientation) };
}

/** The pose in the scene of an eye, or of the head between the eyes, with `pose` in the room. */
export function scenePose(pose: RoomPose, sceneFromRoom: Similarity): Pose {
  const sceneFromCamera = multiply(sceneFromRoom.rotation, multiply(pose.rotation, FLIP));
  return poseAt(transformed(sceneFromRoom, pose.position), transpose(sceneFromCamera));
}
