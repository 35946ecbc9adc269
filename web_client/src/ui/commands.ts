/** The commands of keys and settings, and the panels that they open over the picture. */

import "./full_screen"; // ahead of its use: browsers allow full screen only right after a press
import { FlyMode } from "../camera/fly_mode";
import { element } from "../dom/element";
import type { HgsPlayer } from "../player/hgs_player";
import type { Bookmarks } from "./bookmarks";
import { obey, playerKeys } from "./key_bindings";
import { LatePart } from "./late_part";
import { Panels } from "./panels";
import { PlayerActions } from "./player_actions";
import type { PageTool, PageTools } from "./player_view_options";
import type { SharedView } from "./shared_view";

/** Time to read a line, milliseconds. */
const STAY = 2500;

export class Message {
  readonly node = element("p", { class: "message", role: "status" });
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(signal: AbortSignal) {
    signal.addEventListener("abort", () => clearTimeout(this.#timer));
  }

  show(text: string): void {
    clearTimeout(this.#timer);
    this.node.textContent = text;
    this.#timer = setTimeout(() => {
      this.node.textContent = "";
    }, STAY);
  }
}

/** The parts of the player's view that commands need. */
export interface CommandSurroundings {
  readonly bookmarks: Bookmarks;
  /** The bookmarks have changed. */
  keep(bookmarks: readonly number[]): void;
  /** Root element of the player, in its shadow root. */
  readonly root: HTMLElement;
  /** Container of settings and statistics. */
  readonly place: HTMLElement;
  /** The button of the settings, with their open state. */
  readonly button: HTMLElement;
  /** Target of the player's key events. */
  readonly keys: EventTarget;
  /** The address that opens with the shared view; undefined if the page has none. */
  readonly link?: (shared: SharedView) => string;
  /** The page's tools; undefined if it has none. */
  readonly tools?: PageTools;
  toggleFullscreen(): void;
  /** Show an error. */
  fail(text: string): void;
  /** The repeated stretch or the bookmarks have changed. */
  marked(): void;
}

export class Commands {
  readonly fly: FlyMode;
  readonly actions: PlayerActions;
  readonly #panels: Panels;
  readonly #obey: (event: KeyboardEvent) => void;

  constructor(player: HgsPlayer, surroundings: CommandSurroundings) {
    const { bookmarks, keep, root, place, button, keys, link = null, fail, marked, toggleFullscreen } = surroundings;
    const used = new Set<PageTool>();
    const toggler = (name: keyof PageTools) => {
      const load = surroundings.tools?.[name];
      if (!load) return null;
      const late = new LatePart<PageTool>(async () => load(player, root), fail, player.disposed);
      return () =>
        late.use((tool) => {
          for (const other of used.add(tool)) if (other !== tool && other.active) other.toggle(); // one at a time
          tool.toggle();
        });
    };
    const message = new Message(player.disposed);
    const notify = (text: string) => message.show(text);
    this.fly = new FlyMode(keys, player.camera, player.disposed);
    const changed = () => {
      marked();
      this.#panels.update();
      root.classList.toggle("flying", this.fly.active);
    };
    const actions = new PlayerActions(player, {
      fly: this.fly,
      bookmarks,
      keep,
      notify,
      fail,
      changed,
      link,
      toggleCrop: toggler("crop"),
      togglePath: toggler("path"),
      toggleClean: toggler("clean"),
    });
    this.actions = actions;
    const bindings = playerKeys(player, actions, {
      toggleFullscreen,
      toggleStatistics: () => this.#panels.toggleStatistics(),
      toggleHelp: () => this.#panels.showHelp(),
    });
    this.#obey = obey(bindings);
    this.#panels = new Panels(player, actions, bindings, root, button);
    place.append(this.#panels.node);
    root.append(message.node, this.#panels.help.node);
  }

  toggleSettings(): void {
    this.#panels.toggleSettings();
  }

  /** Execute a key's command. */
  press(event: KeyboardEvent): void {
    if (!this.#panels.help.open && !this.fly.uses(event)) this.#obey(event);
  }
}
