/** A player with its controls, inside one element of a page: nothing of it reaches the page, and nothing of the page reaches it. */

import { FlyMode } from "../camera/fly_mode";
import { listenForGestures } from "../camera/gestures";
import type { Manifest } from "../codec/types";
import { HgsPlayer } from "../player/hgs_player";
import { Bookmarks } from "./bookmarks";
import { element, icon } from "./element";
import { toggleFullscreen } from "./full_screen";
import { HeadsetButtons } from "./headset_buttons";
import { Help } from "./help";
import { BACK, FULLSCREEN } from "./icons";
import { IdleHiding } from "./idle_hiding";
import { type KeyGroup, obeyKeys } from "./key_bindings";
import { Message } from "./message";
import { Notices } from "./notices";
import { pauseOutOfSight } from "./out_of_sight";
import { PlayerActions } from "./player_actions";
import { playerKeys } from "./player_keys";
import { adoptPlayerStyle } from "./player_style";
import type { PlayerViewOptions } from "./player_view_options";
import { SettingsMenu } from "./settings_menu";
import { StatsPanel } from "./stats_panel";
import { steering } from "./steering";
import { Transport } from "./transport";

const LABEL = "Scene; drag to turn, click to play or pause, press ? for all keys";

export class PlayerView {
  readonly player: HgsPlayer;
  /** The element with all of it; keys pressed while the focus is inside are the player's. */
  readonly root = element("div", { class: "player" });
  readonly #options: PlayerViewOptions;
  readonly #host: HTMLElement;
  readonly #stage = element("div", { class: "stage", role: "img", tabindex: 0, "aria-label": LABEL });
  readonly #poster = element("img", { class: "poster", alt: "", hidden: true });
  readonly #controls = element("div", { class: "controls" });
  readonly #title: HTMLElement;
  readonly #notices: Notices;
  readonly #stats: StatsPanel;
  readonly #headset: HeadsetButtons;
  readonly #message: Message;
  readonly #help = new Help();
  readonly #keys: EventTarget;
  readonly #fly: FlyMode;
  readonly #bookmarks: Bookmarks;
  readonly #actions: PlayerActions;
  readonly #bindings: readonly KeyGroup[];
  #transport: Transport | null = null;
  #menu: SettingsMenu | null = null;

  /** @param host gets a shadow root, unless it has an open one that is empty. */
  constructor(host: HTMLElement, options: PlayerViewOptions = {}) {
    this.#host = host;
    this.#options = options;
    const { page, exact = false } = options;
    this.player = new HgsPlayer(this.#stage, options);
    this.#title = element(page ? "h1" : "div", { class: "title" }, options.title ?? "");
    this.#notices = new Notices({
      reload: page ? page.reload : () => void this.player.reload().catch(() => {}),
      home: page?.home ?? null,
    });
    this.#stats = new StatsPanel(this.player);
    this.#headset = new HeadsetButtons(this.player);
    const signal = this.player.disposed;
    this.#message = new Message(signal);
    this.#keys = page ? window : this.root;
    this.#fly = new FlyMode(this.#keys, this.player.camera, signal);
    this.#bookmarks = new Bookmarks(options.bookmarks ?? [], () => page?.keep?.(this.#bookmarks.times));
    this.#actions = new PlayerActions(this.player, {
      fly: this.#fly,
      bookmarks: this.#bookmarks,
      say: (text) => this.#message.say(text),
      fail: (text) => this.#notices.fail(text),
      changed: () => this.#showChoices(),
      link: page?.link ? (shared) => page.link?.(shared) ?? "" : null,
    });
    this.#bindings = playerKeys(this.player, this.#actions, this.#surroundings);
    this.controls = options.controls ?? true;
    this.poster = options.poster ?? null;
    this.root.classList.toggle("whole-page", page !== undefined);
    this.root.append(
      this.#stage,
      this.#poster,
      this.#notices.node,
      this.#message.node,
      this.#controls,
      this.#help.node,
    );
    const shadow = host.shadowRoot ?? host.attachShadow({ mode: "open" });
    adoptPlayerStyle(shadow);
    shadow.replaceChildren(this.root);
    this.#follow();
    if (!exact) this.#obey();
  }

  /** Whether controls are shown. */
  get controls(): boolean {
    return !this.#controls.hidden;
  }

  set controls(shown: boolean) {
    this.#controls.hidden = !shown || (this.#options.exact ?? false);
  }

  /** Address of the picture to show while the scene has none. */
  set poster(address: string | null) {
    if (address) this.#poster.src = address;
    else this.#poster.removeAttribute("src");
    this.#showPoster();
  }

  /** What the scene is called, over the picture. */
  set title(title: string) {
    this.#title.textContent = title;
  }

  /** Fill the screen, or leave it; says why if that fails. */
  toggleFullscreen(): void {
    void toggleFullscreen(this.#host).catch((error: Error) => this.#notices.fail(error.message));
  }

  /** Say in the player that something is wrong, one line for people. */
  fail(message: string): void {
    this.#notices.fail(message);
  }

  /** Stop and give everything back; the host stays, empty. */
  dispose(): void {
    this.player.dispose();
    this.#host.shadowRoot?.replaceChildren();
  }

  #follow(): void {
    const { player } = this;
    const notices = this.#notices;
    const listen = { signal: player.disposed };
    player.addEventListener(
      "loadstart",
      () => {
        this.#transport = null;
        this.#menu?.dispose();
        this.#menu = null;
        this.#controls.replaceChildren();
        this.#showPoster();
        notices.begin();
      },
      listen,
    );
    player.addEventListener("manifest", ({ detail }) => this.#showControls(detail), listen);
    player.addEventListener("firstpicture", () => this.#showPoster(), listen);
    player.addEventListener(
      "frame",
      () => {
        const stats = player.statistics;
        if (!stats) return;
        notices.update(stats, player.stalled);
        this.root.classList.toggle("lost", stats.contextLost);
        this.#transport?.update();
      },
      listen,
    );
    player.addEventListener(
      "error",
      ({ detail }) => {
        // biome-ignore lint/suspicious/noConsole: the player says it in plain words; this is the cause
        console.error(detail.cause);
        notices.fail(detail.message);
      },
      listen,
    );
    pauseOutOfSight(this.#host, player);
  }

  #showPoster(): void {
    const pictured = (this.player.statistics?.firstFrame ?? null) !== null;
    this.#poster.hidden = pictured || !this.#poster.hasAttribute("src");
  }

  #showControls(manifest: Manifest): void {
    const { page } = this.#options;
    const { player } = this;
    if (manifest.title) this.#title.textContent = manifest.title;
    this.#transport = new Transport(player, this.#actions, this.#bookmarks);
    this.#menu = new SettingsMenu(player, this.#actions, this.#bookmarks, this.#surroundings, this.root);
    const button = (label: string, path: string, onclick: () => void) =>
      element("button", { type: "button", class: "round", title: label, "aria-label": label, onclick }, icon(path));
    const bar = element(
      "header",
      { class: "top-bar" },
      page
        ? element("a", { class: "round", title: "All scenes", "aria-label": "All scenes", href: page.home }, icon(BACK))
        : null,
      this.#title,
      this.#headset.node,
      this.#menu.button,
      // Where the browser has it at all: on a phone of Apple only videos can fill the screen.
      "requestFullscreen" in this.#host ? button("Full screen (F)", FULLSCREEN, () => this.toggleFullscreen()) : null,
    );
    this.#controls.replaceChildren(bar, this.#menu.node, this.#stats.node, this.#transport.node);
    this.#showChoices();
  }

  get #surroundings() {
    const stats = this.#stats;
    return {
      get statisticsShown() {
        return !stats.node.hidden;
      },
      toggleStatistics: () => {
        stats.toggle();
        this.#showChoices();
      },
      toggleFullscreen: () => this.toggleFullscreen(),
      toggleHelp: () => this.#help.show(this.#bindings),
    };
  }

  #showChoices(): void {
    this.#transport?.timeline.mark();
    this.#menu?.update();
    this.root.classList.toggle("flying", this.#fly.active);
  }

  #obey(): void {
    const { page } = this.#options;
    const { player, root } = this;
    const signal = player.disposed;
    const gestures = {
      wheelZooms: () => page !== undefined || root.matches(":focus-within"),
      onTap: () => this.#actions.toggle(),
    };
    listenForGestures(this.#stage, steering(player.camera, this.#fly), gestures, signal);
    const ignores = (event: KeyboardEvent, control: EventTarget) =>
      this.#transport === null ||
      this.#help.open ||
      this.#fly.uses(event) ||
      control instanceof HTMLSelectElement ||
      ([" ", "Enter"].includes(event.key) && control instanceof HTMLButtonElement); // which it presses
    obeyKeys(this.#keys, this.#bindings, ignores, signal);
    new IdleHiding(root, this.#keys, () => !player.paused, signal);
  }
}
