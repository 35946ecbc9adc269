/** A player that nobody sees stands still, and goes on when it is seen again. */

import type { HgsPlayer } from "../player/hgs_player";

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
