/** Muting, for the loudspeaker button, a key and a headset's panel. */

/** A player's loudness. */
interface Loudness {
  muted: boolean;
  volume: number;
}

/** First volume after unmuting a player that was turned down to nothing. */
const AUDIBLE = 0.5;

/** Whether there is no sound. */
export const isSilent = ({ muted, volume }: Loudness): boolean => muted || volume === 0;

/** Mute or unmute. */
export function toggleMuted(player: Loudness): void {
  const silent = isSilent(player);
  if (player.volume === 0) player.volume = AUDIBLE;
  player.muted = !silent;
}
