/** Figures of the running player, for the curious. */

import type { ScenePlayer } from "../player/player";
import { element, setText } from "./element";
import { formatBytes, formatCount } from "./format";

const STREAM_NAMES = { connecting: "connecting", open: "connected", retrying: "reconnecting", closed: "closed" };

export class StatsPanel {
  readonly #values = new Map<string, HTMLElement>();
  readonly node = element("dl", { class: "stats", hidden: true, "aria-label": "Statistics" });

  constructor(readonly player: ScenePlayer) {
    for (const name of [
      "Frames/s",
      "Splats drawn",
      "of them moving",
      "Received",
      "First picture",
      "Picture",
      "Stream",
    ]) {
      const value = element("dd");
      this.#values.set(name, value);
      this.node.append(element("dt", {}, name), value);
    }
  }

  toggle(): void {
    this.node.hidden = !this.node.hidden;
  }

  update(canvas: HTMLCanvasElement): void {
    if (this.node.hidden) return;
    const stats = this.player.stats;
    this.#set("Frames/s", stats.framesPerSecond > 0 ? stats.framesPerSecond.toFixed(1) : "–");
    this.#set("Splats drawn", formatCount(stats.splats));
    this.#set("of them moving", formatCount(stats.dynamicSplats));
    this.#set("Received", `${formatBytes(stats.bytes)} of ${formatBytes(stats.bytesTotal)}`);
    this.#set("First picture", stats.firstFrame === null ? "–" : `${(stats.firstFrame / 1000).toFixed(2)} s`);
    this.#set("Picture", `${canvas.width} × ${canvas.height}`);
    this.#set("Stream", STREAM_NAMES[stats.stream]);
  }

  #set(name: string, text: string): void {
    const value = this.#values.get(name);
    if (value) setText(value, text);
  }
}
