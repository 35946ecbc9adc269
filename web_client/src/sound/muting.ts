/** What a loudspeaker's button, a key and a headset's panel do. */

/** A player's loudness. */
interface Loudness {
  muted: boolean;
  volume: number;
}

/** Loudness to begin with where the visitor asks for sound that had been turned down to nothing. */
const AUDIBLE = 0.5;

/** Whether nothing is to be heard. */
export const isSilent = ({ muted, volume }: Loudness): boolean => muted || volume === 0;

/** Mute or unmute. */
export function toggleMuted(player: Loudness): void {
  const silent = isSilent(player);
  if (player.volume === 0) player.volume = AUDIBLE;
  player.muted = !silent;
}
