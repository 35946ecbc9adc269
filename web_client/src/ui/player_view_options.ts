/** What a player with controls is made from. */

import type { HgsPlayer } from "../player/hgs_player";
import type { HgsPlayerOptions } from "../player/hgs_player_events";
import type { SharedView } from "./shared_view";

/** Something of a page's own over the picture. */
export interface PageTool {
  toggle(): void;
}

/** What a page that is a player alone adds. */
export interface WholePage {
  /** Address of the page that leads to other scenes. */
  readonly home: string;
  /** Load the page again. */
  reload(): void;
  /** The address of the page that opens on what is shared; left out where there is none. */
  link?(shared: SharedView): string;
  /** The bookmarks have changed, seconds; the page may keep them in its address. */
  keep?(bookmarks: readonly number[]): void;
  /** Loads the tool that crops the scene, inside all of the player, `root`; left out where there is none. */
  crop?(player: HgsPlayer, root: HTMLElement): Promise<PageTool>;
}

export interface PlayerViewOptions extends HgsPlayerOptions {
  /** Whether to show controls and obey keys, taps and drags; true if left out. */
  readonly controls?: boolean;
  /** What to call the scene until it says so itself. */
  readonly title?: string;
  /** Address of a picture to show until the scene has one of its own. */
  readonly poster?: string | null;
  /** Marked moments to begin with, seconds. */
  readonly bookmarks?: readonly number[];
  /** For a page that is a player alone: all keys and the wheel are the player's. Left out in a page with other things. */
  readonly page?: WholePage;
}
