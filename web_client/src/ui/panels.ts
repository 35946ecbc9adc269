/** The panels over the picture: settings, statistics, help. */

import { element } from "../dom/element";
import { adoptStyle } from "../dom/shadow_style";
import type { HgsPlayer } from "../player/hgs_player";
import { Help } from "./help";
import type { KeyGroup } from "./key_bindings";
import css from "./panels.css?inline";
import type { PlayerActions } from "./player_actions";
import { SettingsMenu } from "./settings_menu";
import { StatsPanel } from "./stats_panel";

export class Panels {
  /** Settings and statistics; the help is a separate dialog. */
  readonly node = element("div");
  readonly help = new Help();
  readonly #statistics: StatsPanel;
  #menu: SettingsMenu | null = null;

  /**
   * Create the panels.
   *
   * @param root root element of the player, in its shadow root.
   * @param button opens the settings, and has their open state.
   */
  constructor(
    readonly player: HgsPlayer,
    readonly actions: PlayerActions,
    readonly keys: readonly KeyGroup[],
    readonly root: HTMLElement,
    readonly button: HTMLElement,
  ) {
    adoptStyle(root.getRootNode() as ShadowRoot, css);
    this.#statistics = new StatsPanel(player);
    const listen = { signal: player.disposed };
    player.addEventListener("loadstart", () => this.#end(), listen);
    player.addEventListener("manifest", () => this.#begin(), listen);
    if (player.manifest) this.#begin();
  }

  get statisticsShown(): boolean {
    return !this.#statistics.node.hidden;
  }

  toggleStatistics(): void {
    this.#statistics.toggle();
    this.update();
  }

  toggleSettings(): void {
    this.#menu?.toggle();
  }

  showHelp(): void {
    this.help.show(this.keys);
  }

  /** Show the current choices. */
  update(): void {
    this.#menu?.update();
  }

  /** Create the settings of the present scene. */
  #begin(): void {
    this.#menu = new SettingsMenu(this.player, this.actions, this, this.root, this.button);
    this.node.replaceChildren(this.#menu.node, this.#statistics.node);
  }

  #end(): void {
    this.#menu?.dispose();
    this.#menu = null;
  }
}
