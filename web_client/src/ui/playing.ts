/** Playing, as taps, the bar below the picture and keys ask for it. */

import type { HgsPlayer } from "../player/hgs_player";

/** Whether anything moves in the scene that is there. */
export const moves = (player: HgsPlayer): boolean => player.duration > 0;

export function togglePlaying(player: HgsPlayer): void {
  if (!moves(player)) return;
  if (player.paused) player.play();
  else player.pause();
}

/** Stand still, so many frames later. */
export function stepFrames(player: HgsPlayer, frames: number): void {
  player.pause();
  player.currentTime += frames / (player.manifest?.frameRate ?? 1);
}
