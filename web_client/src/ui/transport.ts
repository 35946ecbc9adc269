/** The bar below the picture: play, timeline, time. */

import { element, icon, setText } from "../dom/element";
import { formatTime } from "../dom/format";
import { PAUSE, PLAY, REPLAY } from "../dom/icons";
import type { HgsPlayer } from "../player/hgs_player";
import type { Bookmarks } from "./bookmarks";
import { moves, stepFrames, togglePlaying } from "./playing";
import { Timeline } from "./timeline";

type Button = "play" | "pause" | "replay";
const ICONS: Readonly<Record<Button, string>> = { play: PLAY, pause: PAUSE, replay: REPLAY };
const LABELS: Readonly<Record<Button, string>> = { play: "Play", pause: "Pause", replay: "Play again" };

export class Transport {
  readonly #play = element("button", { type: "button", class: "round" });
  readonly #time = element("span", { class: "time" });
  readonly timeline: Timeline;
  readonly node: HTMLElement;
  #shown: Button | null = null;

  /** Create the bar for the present scene. */
  constructor(
    readonly player: HgsPlayer,
    bookmarks: Bookmarks,
  ) {
    this.#play.addEventListener("click", () => togglePlaying(player));
    this.timeline = new Timeline(player, bookmarks, (frames) => stepFrames(player, frames));
    this.node = element("div", { class: "transport" }, this.#play, this.timeline.node, this.#time);
    this.node.hidden = !moves(player);
  }

  /** Show the player's state; called at every frame of the player. */
  update(): void {
    const { player } = this;
    if (this.node.hidden) return;
    const playing = !player.paused || this.timeline.resumes;
    this.#showButton(playing ? "pause" : player.ended ? "replay" : "play");
    setText(this.#time, `${formatTime(player.currentTime - player.start)} / ${formatTime(player.duration)}`);
    this.timeline.update();
  }

  #showButton(what: Button): void {
    if (this.#shown === what) return;
    this.#shown = what;
    this.#play.replaceChildren(icon(ICONS[what]));
    this.#play.setAttribute("aria-label", LABELS[what]);
    this.#play.title = `${LABELS[what]} (Space)`;
  }
}
