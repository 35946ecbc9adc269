/** Options of a player with controls. */

import type { HgsPlayer } from "../player/hgs_player";
import type { HgsPlayerOptions } from "../player/hgs_player_events";
import type { SharedView } from "./shared_view";

/** A page's own tool over the picture. */
export interface PageTool {
  readonly active: boolean;
  toggle(): void;
}

type LoadTool = (player: HgsPlayer, root: HTMLElement) => Promise<PageTool>;

export interface PageTools {
  /** Key frames of a camera path. */
  readonly path: LoadTool;
  /** The crop tool; undefined for visitors without the right to edit, as the cleaning tool. */
  readonly crop?: LoadTool;
  readonly clean?: LoadTool;
}

/** The parts of a page with nothing but a player. */
export interface WholePage {
  /** Address of the page with other scenes. */
  readonly home: string;
  /** Load the page again. */
  reload(): void;
  /** The address of the page that opens with the shared view; undefined if there is none. */
  link?(shared: SharedView): string;
  /** The bookmarks have changed, seconds; the page may keep them in its address. */
  keep?(bookmarks: readonly number[]): void;
  /** The page's tools, which load inside the player's root element; undefined if there are none. */
  readonly tools?: PageTools;
}

export interface PlayerViewOptions extends HgsPlayerOptions {
  /** Whether to show controls and handle keys, taps and drags; default true. */
  readonly controls?: boolean;
  /** The title until the manifest has arrived. */
  readonly title?: string;
  /** Address of a picture before the scene's first one. */
  readonly poster?: string | null;
  /** Initial bookmarks, seconds. */
  readonly bookmarks?: readonly number[];
  /** For a page with nothing but a player: all keys and the wheel are the player's. Undefined for other pages. */
  readonly page?: WholePage;
}
