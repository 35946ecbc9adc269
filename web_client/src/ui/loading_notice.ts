/** What lies over the picture while there is none, or when something is wrong. */

import type { PlayerStats } from "../player/player_types";
import { element, setText } from "./element";
import { formatBytes } from "./format";

export class LoadingNotice {
  readonly #bar = element("progress", { max: 1, "aria-label": "Loading" });
  readonly #text = element("p", { class: "notice-text", role: "status" });
  readonly #message = element("p", { class: "notice-error", role: "alert" });
  readonly node = element(
    "div",
    { class: "notice", "data-kind": "loading" },
    element("div", { class: "notice-box" }, this.#bar, this.#text, this.#message),
  );
  readonly #back = element("a", { class: "button", href: "/" }, "All scenes");
  readonly #again = element(
    "button",
    { type: "button", class: "button", onclick: () => location.reload() },
    "Try again",
  );
  #failed = false;

  /** Show an error and the ways out; it stays. */
  fail(message: string): void {
    if (this.#failed) return;
    this.#failed = true;
    this.node.dataset.kind = "error";
    this.#message.textContent = message;
    this.node.firstElementChild?.append(element("div", { class: "notice-actions" }, this.#again, this.#back));
  }

  update(stats: PlayerStats, stalled: boolean): void {
    if (this.#failed) return;
    if (stats.bytesTotal > 0) this.#bar.value = stats.bytes / stats.bytesTotal;
    const kind = kindOf(stats, stalled);
    if (this.node.dataset.kind !== kind) this.node.dataset.kind = kind;
    setText(this.#text, describe(kind, stats));
  }
}

type Kind = "retrying" | "loading" | "stalled" | "damaged" | "none";

function kindOf(stats: PlayerStats, stalled: boolean): Kind {
  if (stats.stream === "retrying") return "retrying";
  if (stats.firstFrame === null && stats.lostChunks === 0) return "loading";
  if (stalled) return "stalled";
  return stats.lostChunks > 0 ? "damaged" : "none";
}

function describe(kind: Kind, stats: PlayerStats): string {
  if (kind === "none") return "";
  if (kind === "damaged") return "A part of this scene is damaged and cannot be shown.";
  if (kind === "retrying") return "The connection is lost; trying again…";
  if (stats.bytesTotal === 0) return "Connecting…";
  const share = `${formatBytes(stats.bytes)} of ${formatBytes(stats.bytesTotal)}`;
  return kind === "loading" ? `Loading ${share}` : `Waiting for data: ${share}`;
}
