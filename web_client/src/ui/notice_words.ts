/** The sentences of the notices over the picture. */

import { formatBytes } from "../dom/format";
import type { PlayerStats } from "../player/player_types";

/** Kinds of notices: no picture yet, a lost picture, a lost connection, waiting for data; or nothing. */
export type NoticeKind = "loading" | "lost" | "aside" | "retrying" | "stalled" | "none";

export const DAMAGED = "A part of this scene is damaged and cannot be shown.";
export const LOST_FOR_LONG = "The picture has not come back. Reloading the page should help.";

const LOST = "Connection lost. Trying again…";
const RESTARTING = "The server is restarting. One moment…";

/** The sentence for a notice. */
export function describeNotice(kind: NoticeKind, stats: PlayerStats): string {
  const share = `${formatBytes(stats.bytes)} of ${formatBytes(stats.bytesTotal)}`;
  const away = stats.stream === "restarting" ? RESTARTING : LOST;
  switch (kind) {
    case "loading":
      if (stats.stream === "retrying" || stats.stream === "restarting") return away;
      return stats.bytesTotal === 0 ? "Connecting…" : `Loading ${share}`;
    case "lost":
      return "The graphics card was reset. One moment…";
    case "aside":
      return "Press to play this one instead.";
    case "retrying":
      return away;
    case "stalled":
      return stats.atEdge ? "More of this scene is still being made…" : `Waiting for data: ${share}`;
    case "none":
      return "";
  }
}
