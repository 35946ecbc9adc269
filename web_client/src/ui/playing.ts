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

/** Pause `player` while `host` is out of sight, and play on afterwards, until the player is disposed of. */
export function pauseOutOfSight(host: HTMLElement, player: HgsPlayer): void {
  let resumes = false; // only what was paused here
  const observer = new IntersectionObserver((entries) => {
    const seen = entries.at(-1)?.isIntersecting ?? true;
    if (seen) player.seen = true; // it draws again before it plays on
    if (!seen && !player.paused) {
      player.pause();
      resumes = true;
    } else if (seen && resumes) {
      resumes = false;
      player.play();
    }
    if (!seen) player.seen = false; // it has come to stand
  });
  observer.observe(host);
  player.disposed.addEventListener("abort", () => observer.disconnect());
}
