/** The notices over the picture: in the middle before the first picture, later in a quiet line above the controls. */

import { element, icon, setText } from "../dom/element";
import { CLOSE } from "../dom/icons";
import type { PlayerStats } from "../player/player_types";
import { DAMAGED, describeNotice, LOST_FOR_LONG, type NoticeKind } from "./notice_words";

/** Milliseconds in which a lost picture usually returns. */
const PATIENCE = 5000;

/** The notice for a player, which waits for data if `stalled`. */
export function noticeKind(stats: PlayerStats, stalled: boolean): NoticeKind {
  if (stats.contextLost) return "lost";
  if (stats.firstFrame === null) return "loading";
  if (stats.setAside) return "aside";
  if (stats.complete) return "none"; // the server is not needed any more
  if (/ing$/.test(stats.stream)) return "retrying"; // connecting, retrying or restarting
  return stalled ? "stalled" : "none";
}

/** The exits from a failure. */
export interface WaysOut {
  /** Load the page or the scene again. */
  reload(): void;
  /** Address of the page with other scenes; null if there is none. */
  readonly home: string | null;
}

const reloadButton = (onclick: () => void) => element("button", { type: "button", class: "button", onclick }, "Reload");

export class Notices {
  readonly #bar = element("progress", { max: 1, "aria-label": "Loading" });
  readonly #text = element("p", { class: "notice-text", role: "status" });
  readonly #reload: HTMLElement;
  readonly #box = element("div", { class: "notice" }, this.#bar, this.#text);
  readonly #problem = element("p");
  readonly #close = element("button", { type: "button", class: "round", title: "Close", "aria-label": "Close" });
  readonly #remark = element("div", { class: "notice remark", role: "alert", hidden: true }, this.#problem);
  readonly node = element("div", { class: "notices", hidden: true }, this.#remark, this.#box);
  readonly #reported = new Set<string>();
  #kind: NoticeKind = "loading";
  #late = false;
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor({ reload, home }: WaysOut) {
    this.#reload = reloadButton(reload);
    this.#box.append(this.#reload);
    const link = home === null ? null : element("a", { class: "button", href: home }, "All scenes");
    this.#remark.append(
      element("div", { class: "notice-actions" }, reloadButton(reload), ...(link ? [link] : [])),
      this.#close,
    );
    this.#close.append(icon(CLOSE));
    this.#close.addEventListener("click", () => {
      this.#remark.hidden = true;
    });
    this.#show("loading");
  }

  /** Remove the notices of the last scene: another one is loading. */
  begin(): void {
    this.#reported.clear();
    this.#remark.hidden = true;
    this.node.hidden = false;
    setText(this.#text, "");
    this.#bar.removeAttribute("value");
    this.#show("loading");
  }

  /**
   * Show an error. Without a picture it stays, with the exits; over a picture it is a line that can be closed. The
   * first error stays until then, and none is shown twice.
   */
  fail(message: string): void {
    if (!this.#remark.hidden || this.#reported.has(message)) return;
    this.#reported.add(message);
    this.#problem.textContent = message;
    this.#remark.hidden = false;
    this.node.hidden = false;
    this.#show(this.#kind);
  }

  update(stats: PlayerStats, stalled: boolean): void {
    if (stats.lostChunks > 0) this.fail(DAMAGED);
    else if (this.#problem.textContent === DAMAGED) this.#remark.hidden = true; // the chunk has arrived after all
    const kind = noticeKind(stats, stalled);
    if (kind !== this.#kind) this.#show(kind);
    if (stats.bytesTotal > 0) this.#bar.value = stats.bytes / stats.bytesTotal;
    setText(this.#text, this.#late ? LOST_FOR_LONG : describeNotice(kind, stats));
  }

  #show(kind: NoticeKind): void {
    this.#kind = kind;
    this.node.dataset.place = kind === "loading" || kind === "lost" ? "middle" : "line";
    const failed = kind === "loading" && !this.#remark.hidden; // nothing is loading any more
    this.#box.hidden = kind === "none" || failed;
    this.#bar.hidden = kind !== "loading";
    this.#reload.hidden = true;
    this.#late = false;
    clearTimeout(this.#timer);
    if (kind === "lost") this.#timer = setTimeout(() => this.#giveUp(), PATIENCE);
  }

  /** Show a lasting error: the picture may still return, but nobody should wait for it. */
  #giveUp(): void {
    this.#late = true;
    this.#reload.hidden = false;
    setText(this.#text, LOST_FOR_LONG);
  }
}
