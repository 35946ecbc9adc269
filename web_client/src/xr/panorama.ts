/**
 * Small pictures of the scene all round the head: its colours and its coverage in each direction. They are drawn one a
 * frame, and read after the last, so that no frame is late for them.
 */

import type { Intrinsics } from "../camera/pinhole";
import { apply, dot, length, type Mat3, normalise, scale, type Vec3 } from "../camera/vector";
import type { Shot } from "../renderer/shot";
import type { SplatDrawer } from "../renderer/splat_drawer";
import { type RoomPose, scenePose } from "./eye_camera";
import { type Similarity, yawRotation } from "./similarity";

/** Of a face of the cube, pixels: 4 degrees each. */
const SIDE = 24;

/** Ahead, to the left, behind, to the right, above, below; from a camera's own axes to the room's. */
const FACES: readonly Mat3[] = [
  ...[0, 1, 2, 3].map((quarter) => yawRotation((quarter * Math.PI) / 2)),
  [1, 0, 0, 0, 0, -1, 0, 1, 0],
  [1, 0, 0, 0, 0, 1, 0, -1, 0],
];

/** The colour and the coverage of a direction. */
export interface Glimpse {
  /** Of length 1, in the scene's axes. */
  readonly direction: Vec3;
  /** How much of the sphere it stands for, in some unit. */
  readonly size: number;
  /** sRGB, multiplied by alpha. */
  readonly light: Vec3;
  /** How much of the direction the scene covers, 0 to 1. */
  readonly alpha: number;
}

export type Panorama = readonly Glimpse[];

/** Of the glimpses within an angle of `gaze`, given by its cosine, the share that the scene covers. */
export function coverage(panorama: Panorama, gaze: Vec3, cosine: number): number {
  let [covered, all] = [0, 0];
  for (const { direction, size, alpha } of panorama) {
    if (dot(direction, gaze) < cosine) continue;
    covered += size * alpha;
    all += size;
  }
  return all > 0 ? covered / all : 0;
}

export class PanoramaCamera {
  // Not a PictureTarget: what the player's own script gives to others makes it larger for every page.
  readonly #texture: WebGLTexture;
  readonly #framebuffer: WebGLFramebuffer;
  #face = 0;

  /** Take the panorama from where the head is now. */
  constructor(
    readonly head: Vec3,
    readonly sceneFromRoom: Similarity,
    readonly splats: SplatDrawer,
  ) {
    const { gl } = splats;
    this.#texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.#texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA8, SIDE * FACES.length, SIDE);
    this.#framebuffer = gl.createFramebuffer();
    this.#bind();
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.#texture, 0);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
  }

  /** Draw the next of the pictures at the time of `shot`, an eye's; the panorama when there are no more. */
  step(shot: Shot): Panorama | null {
    const rotation = FACES[this.#face];
    if (!rotation) return this.#read();
    const pose: RoomPose = { position: this.head, rotation };
    this.#bind();
    this.splats.draw({ ...shot, pose: scenePose(pose, this.sceneFromRoom), camera: square(shot.camera.near) }, [
      SIDE * this.#face++,
      0,
    ]);
    return null;
  }

  dispose(): void {
    this.splats.gl.deleteFramebuffer(this.#framebuffer);
    this.splats.gl.deleteTexture(this.#texture);
  }

  #bind(): void {
    this.splats.gl.bindFramebuffer(this.splats.gl.FRAMEBUFFER, this.#framebuffer);
  }

  #read(): Panorama {
    const { gl } = this.splats;
    const pixels = new Uint8Array(4 * FACES.length * SIDE * SIDE); // rows from the bottom
    this.#bind();
    gl.readPixels(0, 0, SIDE * FACES.length, SIDE, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    const byte = (at: number): number => pixels[at] / 255;
    return FACES.flatMap((face, f) =>
      Array.from({ length: SIDE * SIDE }, (_, i): Glimpse => {
        const [column, line] = [i % SIDE, Math.floor(i / SIDE)];
        const own: Vec3 = [(2 * column + 1) / SIDE - 1, (2 * line + 1) / SIDE - 1, -1];
        const at = 4 * ((line * FACES.length + f) * SIDE + column);
        return {
          direction: normalise(apply(this.sceneFromRoom.rotation, apply(face, own))),
          size: length(own) ** -3,
          light: [byte(at), byte(at + 1), byte(at + 2)],
          alpha: byte(at + 3),
        };
      }),
    );
  }
}

/** A quarter of the horizon, and as much upright. */
const square = (near: number): Intrinsics => {
  const half = SIDE / 2;
  return { width: SIDE, height: SIDE, fx: half, fy: half, cx: half, cy: half, near };
};

/** The mean colour of a part of a panorama, by how much of it `share` gives each direction, 0 to 1; black for nothing. */
export function meanColour(panorama: Panorama, share: (direction: Vec3) => number): { colour: Vec3; covered: number } {
  let light: Vec3 = [0, 0, 0];
  let [covered, all] = [0, 0];
  for (const glimpse of panorama) {
    const weight = glimpse.size * share(glimpse.direction);
    light = [
      light[0] + weight * glimpse.light[0],
      light[1] + weight * glimpse.light[1],
      light[2] + weight * glimpse.light[2],
    ];
    covered += weight * glimpse.alpha;
    all += weight;
  }
  return { colour: scale(light, covered > 0 ? 1 / covered : 0), covered: all > 0 ? covered / all : 0 };
}
