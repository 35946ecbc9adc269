/** What a loudspeaker's button, a key and a headset's panel do. */

import type { HgsPlayer } from "./hgs_player";

/** Loudness to begin with where the visitor asks for sound that had been turned down to nothing. */
const AUDIBLE = 0.5;

/** Whether nothing is to be heard. */
export const isSilent = ({ muted, volume }: Pick<HgsPlayer, "muted" | "volume">): boolean => muted || volume === 0;

/** Mute, or let sound be heard. */
export function toggleMuted(player: Pick<HgsPlayer, "muted" | "volume">): void {
  const silent = isSilent(player);
  if (player.volume === 0) player.volume = AUDIBLE;
  player.muted = !silent;
}
