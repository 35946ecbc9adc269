/** Tells when a wearer has lost sight of the scene, and which way it is. */

import { add, apply, dot, length, normalise, scale, subtract, type Vec3 } from "../camera/vector";
import type { RoomPose } from "./eye_camera";
import { type Quad, ribbon } from "./flat_drawer";
import { rayOf } from "./panel_layout";
import { coverage, type Panorama } from "./panorama";
import { type Similarity, transformed, transpose } from "./similarity";

/** Half angle of the cone that stands for the field of view. */
const CONE = Math.cos(Math.PI / 4);
/** Share of the view below which the scene may be out of sight. */
const FEW = 0.05;
/** A scene as small as this is not seen however one looks. */
const NOTHING = 0.0005;
const PATIENCE = 1000; // ms

/** In metres. */
const ARROW = { away: 0.8, aside: 0.14, tip: 0.03, wing: 0.05, width: 0.012 };

/**
 * Whether a gaze shows too little: less than a few hundredths of the view, and less than half of a view towards the scene's
 * `middle`. A small scene in the middle of the view is not lost.
 */
export function tooLittle(panorama: Panorama, gaze: Vec3, middle: Vec3): boolean {
  const seen = coverage(panorama, gaze, CONE);
  return seen < FEW && (seen < NOTHING || seen < 0.5 * coverage(panorama, middle, CONE));
}

export class WayBack {
  #since: number | null = null; // ms: when it was last seen
  #towards: Vec3 = [0, 0, -1]; // the scene's middle, from the head, in the head's axes

  /** @param center the scene's middle, world. */
  constructor(readonly center: Vec3) {}

  /** Look at a frame at `now`, milliseconds; returns whether the scene has been out of sight for a while. */
  update(panorama: Panorama | null, head: RoomPose, sceneFromRoom: Similarity, now: number): boolean {
    const { rotation } = sceneFromRoom;
    const offset = subtract(this.center, transformed(sceneFromRoom, head.position));
    this.#towards = apply(transpose(head.rotation), normalise(apply(transpose(rotation), offset)));
    const gaze = apply(rotation, rayOf(head).direction);
    if (!panorama || !tooLittle(panorama, gaze, normalise(offset))) this.#since = now;
    this.#since ??= now;
    return now - this.#since >= PATIENCE;
  }

  /** An arrow before the head towards the scene, for an eye at `eye`; none where it is ahead. */
  arrow({ position, rotation }: RoomPose, eye: Vec3): Quad[] {
    const [x, y, z] = this.#towards;
    if (dot(this.#towards, [0, 0, -1]) > CONE) return [];
    // What is behind is turned to, and not looked up or down to.
    const way = z > 0 ? ([x < 0 ? -1 : 1, 0, 0] as const) : normalise([x, y, 0]);
    const across: Vec3 = [-way[1], way[0], 0];
    const place = (ahead: number, aside: number): Vec3 => {
      const own = add(add(scale(way, ARROW.aside + ahead), scale(across, aside)), [0, 0, -ARROW.away]);
      return add(position, apply(rotation, own));
    };
    const tip = place(ARROW.tip, 0);
    return [-ARROW.wing, ARROW.wing].map((wing) => ribbon(place(-ARROW.tip, wing), tip, ARROW.width, eye));
  }

  /** How far the scene's middle is from a head, in the room's metres. */
  distance(head: Vec3, sceneFromRoom: Similarity): number {
    return length(subtract(this.center, transformed(sceneFromRoom, head))) / sceneFromRoom.scale;
  }
}
