/** Tells when the picture has stopped moving, so that it is worth drawing with care. */

import { sameView, type View } from "./view";

const SETTLING = 150; // ms: the pauses of a dragging hand are shorter

export class Stillness {
  #view: View | null = null;
  #since = 0;

  /** Note what is seen at `now`, milliseconds; returns true if neither view nor scene have moved for a moment. */
  update(view: View, sceneMoves: boolean, now: number): boolean {
    const first = this.#view === null;
    if (sceneMoves || !sameView(this.#view, view)) this.#since = first ? Number.NEGATIVE_INFINITY : now;
    this.#view = view;
    return !sceneMoves && now - this.#since >= SETTLING;
  }
}
