/**
 * The surroundings of the wearer: a panorama of the scene from about the head's position. It gives the backdrop its colours
 * once, and detects from then on that the scene is out of sight.
 */

import { length, subtract, type Vec3 } from "../camera/vector";
import type { Manifest } from "../codec/types";
import type { Shot } from "../renderer/shot";
import type { SplatDrawer } from "../renderer/splat_drawer";
import { Backdrop } from "./backdrop";
import { backdropColours } from "./backdrop_colours";
import type { RoomPose } from "./eye_camera";
import { type Panorama, PanoramaCamera } from "./panorama";
import { type Similarity, transformed } from "./similarity";
import { WayBack } from "./way_back";

/** Delay after all has arrived until the order contains all directions, ms; the page's order has those of its picture. */
const SETTLING = 500;
/** A panorama holds so far from where it was taken: metres, and of the way to the scene's middle. */
const FAR = { metres: 1, share: 0.5 };
/** And for so much of a change of size. */
const RESIZED = 1.3;

export class Outlook {
  readonly backdrop: Backdrop;
  readonly wayBack: WayBack;
  #camera: PanoramaCamera | null = null; // null between panoramas
  #panorama: Panorama | null = null;
  #since: number | null = null; // ms: when all that stands was first there
  #last: Similarity | null = null; // placement at the last panorama
  #head: Vec3 = [0, 0, 0]; // position in the scene, at the last panorama

  /** @param floor whether the room's floor is known, at height 0. */
  constructor(
    readonly manifest: Pick<Manifest, "up" | "background" | "center">,
    floor: boolean,
  ) {
    this.backdrop = new Backdrop(manifest.background, floor);
    this.wayBack = new WayBack(manifest.center);
  }

  /** @param gl a context that is not lost; anew when it has come back. */
  attach(gl: WebGL2RenderingContext): void {
    this.#camera = this.#last = this.#since = null; // possibly a panorama of an empty scene
    this.backdrop.attach(gl);
  }

  /**
   * Look at a frame at `now`, milliseconds, in which an eye sees `shot`, once all that stands still has arrived.
   *
   * @returns whether the wearer has lost the scene
   */
  update(now: number, head: RoomPose, sceneFromRoom: Similarity, shot: Shot, splats: SplatDrawer): boolean {
    this.#since ??= now;
    if (!this.#camera && now - this.#since >= SETTLING && this.#stale(head.position, sceneFromRoom)) {
      this.#last = sceneFromRoom;
      this.#head = transformed(sceneFromRoom, head.position);
      this.#camera = new PanoramaCamera(head.position, sceneFromRoom, splats);
    }
    const taken = this.#camera?.step(shot);
    if (taken) this.#develop(taken, now);
    return this.wayBack.update(this.#panorama, head, sceneFromRoom, now);
  }

  dispose(): void {
    this.#camera?.dispose();
    this.backdrop.dispose();
  }

  #develop(panorama: Panorama, now: number): void {
    this.#camera?.dispose();
    this.#camera = null;
    const { up, background } = this.manifest;
    if (!this.#panorama) this.backdrop.change(backdropColours(panorama, up, background), now);
    this.#panorama = panorama;
  }

  #stale(head: Vec3, sceneFromRoom: Similarity): boolean {
    if (!this.#last) return true;
    const resized = Math.abs(Math.log(sceneFromRoom.scale / this.#last.scale)) > Math.log(RESIZED);
    const moved = length(subtract(transformed(sceneFromRoom, head), this.#head)) / sceneFromRoom.scale;
    return resized || moved > Math.min(FAR.metres, FAR.share * this.wayBack.distance(head, sceneFromRoom));
  }
}
