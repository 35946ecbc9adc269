/** The backdrop of a headset that shows no room: a soft gradient, and a faint disc at the wearer's feet. */

import type { Vec3 } from "../camera/vector";
import { Program } from "../renderer/program";
import fragmentShader from "./backdrop.frag?raw";
import vertexShader from "./backdrop.vert?raw";
import { type BackdropColours, mixed, plain } from "./backdrop_colours";
import type { EyeMatrices } from "./flat_drawer";

const UNIFORMS = ["projection", "eyeFromRoom", "above", "level", "below", "eye", "feet", "disc"] as const;

/** How much lighter than the colours the disc is. */
const DISC = 0.07;
/** So long other colours take to come, ms. */
const CHANGE = 1000;

export class Backdrop {
  #program: Program<(typeof UNIFORMS)[number]> | null = null;
  #gl: WebGL2RenderingContext | null = null;
  #from: BackdropColours;
  #to: BackdropColours;
  #since = 0; // ms

  /** @param floor whether the room's floor is known, at height 0. */
  constructor(
    background: Vec3,
    readonly floor: boolean,
  ) {
    this.#from = this.#to = plain(background);
  }

  /** @param gl a context that is not lost; anew when it has come back. */
  attach(gl: WebGL2RenderingContext): void {
    this.#gl = gl;
    this.#program = new Program(gl, vertexShader, fragmentShader, UNIFORMS);
  }

  /** Take other colours from `now` on, milliseconds, softly. */
  change(colours: BackdropColours, now: number): void {
    this.#from = this.#colours(now);
    this.#to = colours;
    this.#since = now;
  }

  /** Fill the viewport that is set, for an eye at `eye` in the room; the head is at `head`. */
  draw({ projection, eyeFromRoom }: EyeMatrices, eye: Vec3, head: Vec3, now: number): void {
    const [gl, program] = [this.#gl, this.#program];
    if (!gl || !program) return;
    const { uniforms: u } = program;
    const { above, level, below } = this.#colours(now);
    gl.disable(gl.BLEND);
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
    gl.useProgram(program.handle);
    gl.uniformMatrix4fv(u.projection, false, projection);
    gl.uniformMatrix4fv(u.eyeFromRoom, false, eyeFromRoom);
    gl.uniform3f(u.above, ...above);
    gl.uniform3f(u.level, ...level);
    gl.uniform3f(u.below, ...below);
    gl.uniform3f(u.eye, ...eye);
    gl.uniform2f(u.feet, head[0], head[2]);
    gl.uniform1f(u.disc, this.floor ? DISC : 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  dispose(): void {
    this.#program?.dispose();
    this.#program = null;
  }

  #colours(now: number): BackdropColours {
    return mixed(this.#from, this.#to, Math.min(1, Math.max(0, (now - this.#since) / CHANGE)));
  }
}
