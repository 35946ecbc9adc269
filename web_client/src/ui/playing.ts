/** Playing and pausing by taps, keys and buttons, and while the player is out of sight. */

import type { HgsPlayer } from "../player/hgs_player";

/** Whether anything moves in the present scene. */
export const moves = (player: HgsPlayer): boolean => player.duration > 0;

export function togglePlaying(player: HgsPlayer): void {
  if (!moves(player)) return;
  if (player.paused) player.play();
  else player.pause();
}

/** Pause a number of frames later. */
export function stepFrames(player: HgsPlayer, frames: number): void {
  player.pause();
  player.currentTime += frames / (player.manifest?.frameRate ?? 1);
}

/** Pause `player` while `host` is out of sight, and play again afterwards, until the player is disposed of. */
export function pauseOutOfSight(host: HTMLElement, player: HgsPlayer): void {
  let resumes = false; // true after a pause by this function
  const observer = new IntersectionObserver((entries) => {
    const seen = entries.at(-1)?.isIntersecting ?? true;
    if (seen) player.seen = true; // draws before it plays
    if (!seen && !player.paused) {
      player.pause();
      resumes = true;
    } else if (seen && resumes) {
      resumes = false;
      player.play();
    }
    if (!seen) player.seen = false; // the player has paused
  });
  observer.observe(host);
  player.disposed.addEventListener("abort", () => observer.disconnect());
}
