/** The panel of controls in the room: in front of the viewer on demand, and hidden otherwise. */

import { add, apply, dot, length, normalise, row, scale, subtract, type Vec3 } from "../camera/vector";
import type { RoomPose } from "./eye_camera";
import { type EyeMatrices, FlatDrawer, type Quad } from "./flat_drawer";
import { type Control, controlAt, onPanel, PANEL, type PanelPoint, pointOn, type Ray, rayOf } from "./panel_layout";
import { PanelPicture, type PanelState } from "./panel_picture";
import { multiply, transpose, yawRotation } from "./similarity";

const AWAY = 0.8; // metres in front of the eyes
const BELOW = 0.35; // metres below the eyes
const IDLE = 5000; // ms without input before it hides
/** Distance, metres, and angle to the gaze beyond which the panel follows the viewer. */
const LOST = { distance: 1.5, cosine: Math.cos(0.9) };

export class Panel {
  readonly #picture = new PanelPicture();
  #drawer: FlatDrawer | null = null;
  #place: RoomPose | null = null; // null before it is first shown
  #until = 0; // ms

  /**
   * Draw with a context.
   *
   * @param gl a context that is not lost; to be called again after a restoration.
   */
  attach(gl: WebGL2RenderingContext): void {
    this.#drawer = new FlatDrawer(gl);
    this.#drawer.upload(this.#picture.canvas);
  }

  shown(now: number): boolean {
    return this.#place !== null && now < this.#until;
  }

  /** Show the panel in view of the head at `head`, after an input. */
  wake(head: RoomPose, now: number): void {
    if (!this.shown(now) || this.#outOfSight(head)) this.#place = placeBefore(head);
    this.#until = now + IDLE;
  }

  /** The intersection of a ray with the visible panel. */
  pointed(ray: Ray, now: number): (PanelPoint & { readonly control: Control | null }) | null {
    if (!this.#place || !this.shown(now)) return null;
    const point = pointOn(this.#place, ray);
    return point && onPanel(point) ? { ...point, control: controlAt(point.x, point.y) } : null;
  }

  /** The intersection of a ray with the whole plane of the panel: for a drag that leaves it. */
  beside(ray: Ray): PanelPoint | null {
    return this.#place && pointOn(this.#place, ray);
  }

  paint(state: PanelState): void {
    if (this.#picture.paint(state)) this.#drawer?.upload(this.#picture.canvas);
  }

  draw(eye: EyeMatrices): void {
    if (this.#place) this.#drawer?.draw(quadOf(this.#place), eye);
  }

  /** Draw another flat object with the same program. */
  drawQuad(quad: Quad, eye: EyeMatrices, colour: readonly [number, number, number, number]): void {
    this.#drawer?.draw(quad, eye, colour);
  }

  dispose(): void {
    this.#drawer?.dispose();
    this.#drawer = null;
  }

  #outOfSight(head: RoomPose): boolean {
    if (!this.#place) return true;
    const offset = subtract(this.#place.position, head.position);
    const gaze = rayOf(head).direction;
    return length(offset) > LOST.distance || dot(normalise(offset), gaze) < LOST.cosine;
  }
}

/** A level place in front of the viewer, below the eyes, with its face tilted towards them. */
function placeBefore(head: RoomPose): RoomPose {
  const [x, , z] = rayOf(head).direction;
  const level = yawRotation(Math.atan2(-x, -z));
  const offset: Vec3 = [0, -BELOW, -AWAY];
  const tilt = Math.atan2(BELOW, AWAY);
  const [c, s] = [Math.cos(tilt), Math.sin(tilt)];
  const rotation = multiply(level, [1, 0, 0, 0, c, s, 0, -s, c]);
  return { position: add(head.position, apply(level, offset)), rotation };
}

function quadOf({ position, rotation }: RoomPose): Quad {
  const axes = transpose(rotation);
  const along = scale(row(axes, 0), PANEL.width);
  const up = scale(row(axes, 1), PANEL.height);
  return { corner: subtract(position, scale(add(along, up), 0.5)), along, up };
}
