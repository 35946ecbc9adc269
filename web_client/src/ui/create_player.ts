/** A function that creates a player with controls. */

import type { HgsPlayer } from "../player/hgs_player";
import type { OpenSource } from "../source/scene_source";
import { PlayerView } from "./player_view";
import type { PlayerViewOptions } from "./player_view_options";

export interface CreatePlayerOptions extends PlayerViewOptions {
  /** The scene to load at once. See `HgsPlayer.load`. */
  readonly src?: string | OpenSource;
}

/**
 * Create a player with controls that fills an element of the page; `dispose()` removes it.
 *
 * @example
 * const player = createPlayer(document.querySelector("#scene"), { src: "studio/manifest.json", autoplay: true });
 * player.addEventListener("ended", () => player.camera.look("cam01"));
 *
 * @param container an element with a size of its own.
 * @throws RangeError if `playbackRate` is not in (0, 16], or `splatBudget` not at least 1.
 */
export function createPlayer(container: HTMLElement, options: CreatePlayerOptions = {}): HgsPlayer {
  const host = document.createElement("div");
  Object.assign(host.style, { width: "100%", height: "100%" });
  container.append(host);
  const { player } = new PlayerView(host, options);
  player.disposed.addEventListener("abort", () => host.remove());
  if (options.src !== undefined) player.load(options.src).catch(() => {}); // `error` reports failures
  return player;
}
