/** All that keys and the settings do with a player, and what they open over its picture. */

import { FlyMode } from "../camera/fly_mode";
import type { HgsPlayer } from "../player/hgs_player";
import type { Bookmarks } from "./bookmarks";
import { obey } from "./key_bindings";
import { Panels } from "./panels";
import { PlayerActions } from "./player_actions";
import { playerKeys } from "./player_keys";
import type { SharedView } from "./shared_view";

/** The player's view, as far as commands reach it. */
export interface CommandSurroundings {
  readonly bookmarks: Bookmarks;
  /** All of the player, in its shadow root. */
  readonly root: HTMLElement;
  /** Where settings and statistics go. */
  readonly place: HTMLElement;
  /** Opens the settings, and tells whether they are open. */
  readonly button: HTMLElement;
  /** Where the player's keys are heard. */
  readonly keys: EventTarget;
  /** The address that opens on what is shared; left out where the page has none. */
  readonly link?: (shared: SharedView) => string;
  toggleFullscreen(): void;
  /** Say what was done. */
  say(text: string): void;
  /** Say what went wrong. */
  fail(text: string): void;
  /** The repeated stretch or the bookmarks have changed. */
  marked(): void;
}

export class Commands {
  readonly fly: FlyMode;
  readonly #panels: Panels;
  readonly #obey: (event: KeyboardEvent) => void;

  constructor(player: HgsPlayer, surroundings: CommandSurroundings) {
    const { bookmarks, root, place, button, keys, link = null, say, fail, marked, toggleFullscreen } = surroundings;
    this.fly = new FlyMode(keys, player.camera, player.disposed);
    const changed = () => {
      marked();
      this.#panels.update();
      root.classList.toggle("flying", this.fly.active);
    };
    const actions = new PlayerActions(player, { fly: this.fly, bookmarks, say, fail, changed, link });
    const bindings = playerKeys(player, actions, {
      toggleFullscreen,
      toggleStatistics: () => this.#panels.toggleStatistics(),
      toggleHelp: () => this.#panels.showHelp(),
    });
    this.#obey = obey(bindings);
    this.#panels = new Panels(player, actions, bindings, root, button);
    place.append(this.#panels.node);
    root.append(this.#panels.help.node);
  }

  toggleSettings(): void {
    this.#panels.toggleSettings();
  }

  /** Obey a key. */
  press(event: KeyboardEvent): void {
    if (!this.#panels.help.open && !this.fly.uses(event)) this.#obey(event);
  }
}
