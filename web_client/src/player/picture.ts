/**
 * The picture on the canvas: drawn when it is out of date and the device has finished the last one; in motion in the
 * fineness of a steady rate, at rest in the best one.
 */

import type { CanvasRenderer } from "../renderer/canvas_renderer";
import { type Fineness, LADDER } from "../renderer/fineness";
import type { Shot } from "../renderer/shot";
import { sameView, type View } from "../scene/view";

export class Picture {
  readonly frames = new FrameRate();
  readonly #stillness = new Stillness();
  #drawn: Shot | null = null; // null when the picture is out of date
  #rung = 0; // rung of the last picture on the ladder of finenesses
  #aim = 0; // rung for the next picture
  #first: number | null = null;

  constructor(
    readonly renderer: CanvasRenderer,
    readonly scene: { readonly pictured: boolean },
  ) {}

  /** Milliseconds from opening the page to the first picture; null before. */
  get first(): number | null {
    return this.#first;
  }

  /** Fineness of the last picture. */
  get fineness(): Fineness {
    return LADDER[this.#rung];
  }

  /** Largest number of splats for its order, as of the last `update`. */
  get splats(): number {
    return this.renderer.quality.splats(this.#aim);
  }

  /** The order has changed, or the canvas was lost. */
  outdate(): void {
    this.#drawn = null;
  }

  /** Whether `shot` is drawn in the best fineness, or in motion in that of motion. */
  shows(shot: Shot, moving: boolean): boolean {
    return !this.renderer.lost && this.#current(shot) && (moving || this.#rung === this.renderer.quality.resting);
  }

  /**
   * Draw if it is time to; called once per frame of the browser. `moving`: the scene moves. `now` in milliseconds.
   *
   * Returns whether the next frame may draw more even if nothing changes until then.
   */
  update(shot: Shot, moving: boolean, now: number): boolean {
    const still = this.#stillness.update(shot, moving, now);
    const { quality } = this.renderer;
    this.#aim = still ? quality.resting : quality.moving;
    const drawn = this.#draw(shot, this.#aim, now);
    if (moving && !drawn) this.frames.drop();
    // Also until the device has finished: its pace is unknown before.
    return !this.renderer.lost && (this.renderer.busy(now) || (this.#rung !== quality.resting && !moving));
  }

  /** Note a frame drawn at `now`, milliseconds, on the canvas or elsewhere. */
  countFrame(now: number): void {
    this.frames.count(now);
    if (this.#first === null && this.scene.pictured) this.#first = performance.now();
  }

  #draw(shot: Shot, rung: number, now: number): boolean {
    const current = this.#current(shot) && this.#rung <= rung;
    if (current || this.renderer.lost || this.renderer.busy(now)) return false;
    this.renderer.draw(shot, rung);
    this.#drawn = shot;
    this.#rung = rung;
    this.countFrame(now);
    return true;
  }

  #current(shot: Shot): boolean {
    return sameView(this.#drawn, shot) && this.#drawn?.time === shot.time;
  }
}

const SETTLING = 150; // ms: a dragging hand pauses for less

export class Stillness {
  #view: View | null = null;
  #since = 0;

  /** Note the view at `now`, milliseconds; returns true if neither view nor scene have moved for a moment. */
  update(view: View, sceneMoves: boolean, now: number): boolean {
    const first = this.#view === null;
    if (sceneMoves || !sameView(this.#view, view)) this.#since = first ? Number.NEGATIVE_INFINITY : now;
    this.#view = view;
    return !sceneMoves && now - this.#since >= SETTLING;
  }
}

const WINDOW = 1000; // ms

export class FrameRate {
  readonly #times: number[] = []; // times of the frames of the last second, or of the last two frames
  #resting = false;
  #drawn = 0;
  #dropped = 0;

  /** Frames drawn so far. */
  get drawn(): number {
    return this.#drawn;
  }

  /** Frames that were due while the scene played and were not drawn. */
  get dropped(): number {
    return this.#dropped;
  }

  /** Note a frame drawn at `now`, milliseconds. */
  count(now: number): void {
    const times = this.#times;
    if (this.#resting && now - (times.at(-1) ?? now) > WINDOW) times.length = 0;
    this.#resting = false;
    this.#drawn++;
    times.push(now);
    while (times.length > 2 && times[0] < now - WINDOW) times.shift();
  }

  /** Note a frame that is due and not drawn. */
  drop(): void {
    this.#dropped++;
  }

  /** Note that no frame is due until the next one is counted. */
  rest(): void {
    this.#resting = true;
  }

  /** Frames per second at `now`; 0 after a second of rest. A frame that is late lowers the rate before it comes. */
  rate(now: number): number {
    const times = this.#times;
    const since = now - (times.at(-1) ?? now);
    if (times.length === 0 || (this.#resting && since > WINDOW)) return 0;
    const mean = ((times.length - 1) * 1000) / (times[times.length - 1] - times[0] || 1);
    if (since <= WINDOW) return mean;
    return times.length > 1 ? Math.min(mean, 1000 / since) : 1000 / since;
  }
}
