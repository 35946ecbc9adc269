/** Grabbing the scene: one hand moves and turns it, two hands scale it, too. The vertical stays upright. */

import { add, length, type Mat3, scale, subtract, type Vec3 } from "../camera/vector";
import { compose, inverse, motion, multiply, type Similarity, transpose, yawOf } from "./similarity";

/** A hand that holds the scene. */
export interface Hold {
  /** Identity of the hand. */
  readonly hand: object;
  /** In the room, metres. */
  readonly position: Vec3;
  readonly rotation: Mat3;
}

/** Largest factor of enlargement or reduction, relative to the first size. */
const LARGEST = 50;
/** Distance of hands below which they define no direction, metres. */
const APART = 0.02;

export class Grab {
  #last: readonly Hold[] = [];

  /**
   * Move the scene with the hands that hold it.
   *
   * @param usual world units to a metre at first
   */
  update(sceneFromRoom: Similarity, holds: readonly Hold[], usual: number): Similarity {
    const last = this.#last;
    this.#last = holds;
    // When a hand releases the scene or joins, the others continue from there.
    const same = holds.length === last.length && holds.every(({ hand }, i) => hand === last[i].hand);
    if (!same || holds.length === 0) return sceneFromRoom;
    // The scene shrinks as world units to a metre grow.
    const moved = holds.length === 1 ? oneHand(last[0], holds[0]) : twoHands(last, holds, sceneFromRoom.scale / usual);
    return compose(sceneFromRoom, inverse(moved));
  }
}

function oneHand(before: Hold, after: Hold): Similarity {
  const turn = yawOf(multiply(after.rotation, transpose(before.rotation)));
  return motion(turn, 1, before.position, after.position);
}

/** Motion by two hands. `shrunk`: the scene's reduction relative to the first size. */
function twoHands([a, b]: readonly Hold[], [c, d]: readonly Hold[], shrunk: number): Similarity {
  const before = subtract(b.position, a.position);
  const after = subtract(d.position, c.position);
  const flat = ([x, , z]: Vec3) => Math.hypot(x, z);
  const yaw = ([x, , z]: Vec3) => Math.atan2(-z, x);
  const turn = flat(before) > APART && flat(after) > APART ? yaw(after) - yaw(before) : 0;
  const wanted = length(before) > APART && length(after) > APART ? length(after) / length(before) : 1;
  const factor = Math.min(LARGEST * shrunk, Math.max(shrunk / LARGEST, wanted));
  const middle = (p: Hold, q: Hold) => scale(add(p.position, q.position), 0.5);
  return motion(turn, factor, middle(a, b), middle(c, d));
}

/** The scene after the viewer, with the head at `head` in the room, has turned to the left by `angle`, radians. */
export function turned(sceneFromRoom: Similarity, head: Vec3, angle: number): Similarity {
  return compose(sceneFromRoom, motion(angle, 1, head, head));
}
