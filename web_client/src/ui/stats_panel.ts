/** Figures of the running player, for the curious. */

import { element, setText } from "../dom/element";
import { formatBytes } from "../dom/format";
import type { HgsPlayer } from "../player/hgs_player";
import type { PlayerStats } from "../player/player_types";

/** Milliseconds between updates: often enough to follow, slowly enough to read. */
const REFRESH = 500;
const NO_SOCKETS = "HTTP: no WebSockets here";
const STREAM_NAMES = {
  connecting: "connecting",
  open: "connected",
  "over-http": NO_SOCKETS,
  retrying: "reconnecting",
  restarting: "server restarts",
  closed: "closed",
};

/** Display of a figure without a meaning now. */
const NOTHING = "–";

type Figures = Readonly<Record<string, string>>;

/** The picture's size, in its own pixels, and its quality. */
type ShownPicture = Pick<HgsPlayer, "width" | "height" | "quality">;

/** The panel's rows, from top to bottom. */
export function figuresOf(stats: PlayerStats, { width, height, quality }: ShownPicture): Figures {
  const { framesPerSecond: rate, framesDrawn: drawn, framesDropped: dropped, fineness } = stats;
  const { scale, float } = fineness;
  const first = stats.firstFrame === null ? null : stats.firstFrame - stats.loadStart;
  return {
    "Frames/s": rate > 0 ? rate.toFixed(rate < 1 ? 2 : 1) : "at rest",
    "Dropped frames": drawn + dropped > 0 ? `${dropped} of ${drawn + dropped}` : NOTHING,
    "Order age": rate > 0 ? `${stats.orderAge.toFixed(0)} ms` : NOTHING,
    "Sort time": stats.splats > 0 ? `${stats.sortTime.toFixed(1)} ms` : NOTHING,
    "Splats drawn": formatCount(stats.splats),
    "Moving splats": formatCount(stats.dynamicSplats),
    Received: `${formatBytes(stats.bytes)} of ${formatBytes(stats.bytesTotal)}`,
    "Line rate": stats.lineRate > 0 ? formatBitRate(stats.lineRate) : NOTHING,
    "First picture": first === null ? NOTHING : `${(first / 1000).toFixed(2)} s`,
    Picture: `${width} × ${height}`,
    Quality: quality === "auto" ? "auto" : `always ${quality}`,
    "Drawn at": `${Math.round(width * scale)} × ${Math.round(height * scale)}, ${float ? "half floats" : "8 bits"}`,
    Stream: stats.complete && stats.stream !== "over-http" ? "complete" : STREAM_NAMES[stats.stream],
  };
}

export class StatsPanel {
  readonly #values = new Map<string, HTMLElement>();
  #timer: ReturnType<typeof setInterval> | undefined;
  readonly node = element("dl", { class: "stats", hidden: true, "aria-label": "Statistics" });

  constructor(readonly player: HgsPlayer) {
    player.disposed.addEventListener("abort", () => clearInterval(this.#timer));
  }

  toggle(): void {
    this.node.hidden = !this.node.hidden;
    clearInterval(this.#timer);
    if (this.node.hidden) return;
    this.#timer = setInterval(() => this.#update(), REFRESH);
    this.#update();
  }

  #update(): void {
    const { statistics } = this.player;
    if (!statistics) return;
    for (const [name, text] of Object.entries(figuresOf(statistics, this.player))) {
      setText(this.#values.get(name) ?? this.#add(name), text);
    }
  }

  #add(name: string): HTMLElement {
    const value = element("dd");
    this.#values.set(name, value);
    this.node.append(element("dt", {}, name), value);
    return value;
  }
}

/** Bytes per second as "512 kbit/s" or "1.9 Mbit/s", the units of network connections. */
export function formatBitRate(bytesPerSecond: number): string {
  const kilobits = (8 * bytesPerSecond) / 1000;
  return kilobits < 999.5 ? `${Math.round(kilobits)} kbit/s` : `${(kilobits / 1000).toFixed(1)} Mbit/s`;
}

/** "950", "12.4k", "1.2M" */
export function formatCount(count: number): string {
  if (count < 1000) return String(count);
  if (count < 999_500) return `${(count / 1000).toFixed(count < 100_000 ? 1 : 0)}k`;
  return `${(count / 1e6).toFixed(1)}M`;
}
