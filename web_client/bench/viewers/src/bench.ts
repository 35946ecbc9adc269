/** Draws frames of one viewer on demand; the processor time that they take is measured outside of the browser. */

import { pump } from "./frames";
import type { BenchCamera, BenchedViewer, Vec3 } from "./viewer";

/** A picture that has not changed for so long, milliseconds, and so many frames, is settled. */
const QUIET = 700;
const QUIET_FRAMES = 4;
const LONGEST = 60_000;
const ORBIT_STEP = 9; // degrees a frame

export class Bench {
  readonly #pixels: Uint8Array;

  constructor(
    readonly viewer: BenchedViewer,
    readonly camera: BenchCamera,
    readonly width: number,
    readonly height: number,
  ) {
    this.#pixels = new Uint8Array(4 * width * height);
  }

  /** Wait for the first settled picture. */
  async load(): Promise<void> {
    this.viewer.look(this.camera);
    await this.#settle();
  }

  /** Draw the same picture `count` times; the order of the splats is not made anew. */
  async still(count: number): Promise<void> {
    for (let i = 0; i < count; i++) await this.#frame();
  }

  /** Draw `count` pictures on the way around the scene. */
  async orbit(count: number): Promise<void> {
    for (let i = 0; i < count; i++) {
      this.viewer.look(this.#turned(i * ORBIT_STEP));
      await this.#frame();
    }
  }

  /** Draw `count` pictures while the scene plays. */
  async play(count: number): Promise<void> {
    this.viewer.play?.(true);
    for (let i = 0; i < count; i++) await this.#frame();
    this.viewer.play?.(false);
  }

  /** The settled picture from `degrees` around the scene: RGBA from the bottom row, base64. */
  async image(degrees: number): Promise<string> {
    this.viewer.look(this.#turned(degrees));
    await this.#settle();
    let text = "";
    for (let i = 0; i < this.#pixels.length; i += 32768) {
      text += String.fromCharCode(...this.#pixels.subarray(i, i + 32768));
    }
    return btoa(text);
  }

  /** One frame, drawn to its end: reading a pixel waits for the device. */
  async #frame(width = 1, height = 1): Promise<void> {
    pump();
    this.viewer.draw?.();
    const { gl } = this.viewer;
    const framebuffer = gl.getParameter(gl.READ_FRAMEBUFFER_BINDING) as WebGLFramebuffer | null;
    const buffer = gl.getParameter(gl.PIXEL_PACK_BUFFER_BINDING) as WebGLBuffer | null;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, this.#pixels);
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, framebuffer);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
    await new Promise((resolve) => setTimeout(resolve, 0));
  }

  /** Draw until the picture has not changed for a while. */
  async #settle(): Promise<void> {
    const begun = performance.now();
    let before = 0;
    let since = begun;
    let same = 0;
    while (same < QUIET_FRAMES || performance.now() - since < QUIET) {
      if (performance.now() - begun > LONGEST) throw new Error("the picture does not settle");
      await this.#frame(this.width, this.height);
      const hash = hashOf(this.#pixels);
      same = hash === before && !this.viewer.busy?.() ? same + 1 : 0;
      if (hash !== before) since = performance.now();
      before = hash;
    }
  }

  /** The camera, turned about its up axis through the target. */
  #turned(degrees: number): BenchCamera {
    const { eye, target, up } = this.camera;
    const [c, s] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
    const d: Vec3 = [eye[0] - target[0], eye[1] - target[1], eye[2] - target[2]];
    const along = (up[0] * d[0] + up[1] * d[1] + up[2] * d[2]) * (1 - c);
    const turned: Vec3 = [
      target[0] + d[0] * c + (up[1] * d[2] - up[2] * d[1]) * s + up[0] * along,
      target[1] + d[1] * c + (up[2] * d[0] - up[0] * d[2]) * s + up[1] * along,
      target[2] + d[2] * c + (up[0] * d[1] - up[1] * d[0]) * s + up[2] * along,
    ];
    return { ...this.camera, eye: turned };
  }
}

/** FNV-1a over 32-bit words. */
function hashOf(bytes: Uint8Array): number {
  let hash = 2166136261;
  for (const word of new Uint32Array(bytes.buffer)) hash = Math.imul(hash ^ word, 16777619);
  return hash >>> 0;
}
