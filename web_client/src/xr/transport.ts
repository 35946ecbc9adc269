/** The player's playhead for the panel, and its control by hands. */

import type { HgsPlayer } from "../player/hgs_player";
import { isSilent, toggleMuted } from "../sound/muting";
import type { Commands } from "./controls";
import type { Control } from "./panel_layout";
import type { PanelState } from "./panel_picture";

type Playable = Pick<
  HgsPlayer,
  "start" | "end" | "currentTime" | "paused" | "play" | "pause" | "muted" | "volume" | "manifest"
>;

/** "1:05.2" */
function clockTime(seconds: number): string {
  const tenths = Math.round(10 * Math.max(0, seconds));
  const rest = ((tenths % 600) / 10).toFixed(1).padStart(4, "0");
  return `${Math.floor(tenths / 600)}:${rest}`;
}

/** @param lost whether the scene is out of sight. */
export function panelState(player: Playable, pointed: Control | null, lost = false): PanelState {
  const { start, end, currentTime } = player;
  const muted = player.manifest?.audio ? isSilent(player) : null;
  if (!(end > start)) return { playing: false, moves: false, share: 0, time: "", muted, pointed, lost };
  const [passed, duration] = [currentTime - start, end - start];
  const time = `${clockTime(passed)} / ${clockTime(duration)}`;
  return { playing: !player.paused, moves: true, share: passed / duration, time, muted, pointed, lost };
}

export function sceneCommands(player: Playable): Pick<Commands, "togglePlay" | "toggleMuted" | "scrub" | "seek"> {
  const go = (time: number): void => {
    if (player.end > player.start) player.currentTime = Math.min(player.end, Math.max(player.start, time));
  };
  return {
    togglePlay: () => (player.paused ? player.play() : player.pause()),
    toggleMuted: () => {
      if (player.manifest?.audio) toggleMuted(player);
    },
    scrub: (share) => go(player.currentTime + share * (player.end - player.start)),
    seek: (share) => go(player.start + share * (player.end - player.start)),
  };
}
