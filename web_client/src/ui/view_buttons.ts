/** The buttons of the top bar for the view: a link to it, and the way back to its camera; and a hint that it turns. */

import { element, icon } from "../dom/element";
import type { HgsPlayer } from "../player/hgs_player";
import type { Viewing } from "../player/viewpoint";
import { dress } from "./round_button";

// Not among dom/icons.ts, which every page loads.
const LINK =
  "M10.6 13.4a1 1 0 0 1-1.4 1.4 4.5 4.5 0 0 1 0-6.4l3.2-3.2a4.5 4.5 0 0 1 6.4 6.4l-1.5 1.5a6 6 0 0 0-.3-2.5l.4-.4a2.5 2.5 0 0 0-3.6-3.6l-3.2 3.2a2.5 2.5 0 0 0 0 3.6zm2.8-2.8a1 1 0 0 1 1.4-1.4 4.5 4.5 0 0 1 0 6.4l-3.2 3.2a4.5 4.5 0 0 1-6.4-6.4l1.5-1.5a6 6 0 0 0 .3 2.5l-.4.4a2.5 2.5 0 0 0 3.6 3.6l3.2-3.2a2.5 2.5 0 0 0 0-3.6z";
const RECENTRE =
  "M11 2h2v3.1a7 7 0 0 1 5.9 5.9H22v2h-3.1a7 7 0 0 1-5.9 5.9V22h-2v-3.1A7 7 0 0 1 5.1 13H2v-2h3.1A7 7 0 0 1 11 5.1zm1 5a5 5 0 1 0 0 10 5 5 0 0 0 0-10zm0 3a2 2 0 1 1 0 4 2 2 0 0 1 0-4z";

/** Key in the page's storage; present once the visitor has turned a scene. */
const TURNED = "hgs-turned";
const STILL = 1e-6; // world units

export interface ViewActions {
  /** Copy a link to the view; null if the page has none. */
  readonly share: (() => void) | null;
  recentre(): void;
}

export class ViewButtons {
  readonly share: HTMLElement | null;
  readonly recentre: HTMLElement;
  /** Null once the visitor has turned a scene. */
  readonly hint: HTMLElement | null;
  #camera: string | null = null;
  #first: Viewing | null = null;

  /**
   * Create the buttons for the present scene.
   *
   * @param hints whether the page may keep in its storage that the visitor has turned a scene.
   */
  constructor(
    readonly player: HgsPlayer,
    { share, recentre }: ViewActions,
    readonly hints: boolean,
  ) {
    this.share = share && dress(element("button", { onclick: share }), "Copy a link to this view (C)", LINK);
    this.recentre = dress(element("button", { onclick: recentre, hidden: true }), "Back to the camera (R)", RECENTRE);
    this.hint =
      hints && !hasTurned() ? element("p", { class: "turn-hint" }, icon(RECENTRE), "Drag to look around") : null;
  }

  /** Show the way back once the camera has moved, and the hint until then. */
  update(): void {
    const { name, view } = this.player.camera;
    if (this.#first === null || name !== this.#camera) [this.#first, this.#camera] = [view, name];
    const moved = view !== null && this.#first !== null && !alike(view, this.#first);
    this.recentre.hidden = !moved;
    if (moved && this.hint?.isConnected) {
      this.hint.remove();
      keepTurned();
    }
  }
}

const alike = (a: Viewing, b: Viewing): boolean =>
  a.position.every((value, axis) => Math.abs(value - b.position[axis]) < STILL) &&
  a.target.every((value, axis) => Math.abs(value - b.target[axis]) < STILL);

/** Browsers may refuse a page its storage. */
function hasTurned(): boolean {
  try {
    return localStorage.getItem(TURNED) !== null;
  } catch {
    return false;
  }
}

function keepTurned(): void {
  try {
    localStorage.setItem(TURNED, "1");
  } catch {
    // the hint is shown again next time
  }
}
