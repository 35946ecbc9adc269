/** A player with its controls, inside one element of a page: nothing of it reaches the page, and nothing of the page reaches it. */

import { listenForGestures, listenForKeys } from "../camera/gestures";
import type { Manifest } from "../codec/types";
import { HgsPlayer } from "../player/hgs_player";
import type { HgsPlayerOptions } from "../player/hgs_player_events";
import { CameraMenu } from "./camera_menu";
import { element, icon } from "./element";
import { toggleFullscreen } from "./full_screen";
import { HeadsetButtons } from "./headset_buttons";
import { BACK, FULLSCREEN, STATS } from "./icons";
import { IdleHiding } from "./idle_hiding";
import { Notices } from "./notices";
import { pauseOutOfSight } from "./out_of_sight";
import { adoptPlayerStyle } from "./player_style";
import { StatsPanel } from "./stats_panel";
import { Transport } from "./transport";

/** What a page that is a player alone adds. */
export interface WholePage {
  /** Address of the page that leads to other scenes. */
  readonly home: string;
  /** Load the page again. */
  reload(): void;
}

export interface PlayerViewOptions extends HgsPlayerOptions {
  /** Whether to show controls and obey keys, taps and drags; true if left out. */
  readonly controls?: boolean;
  /** What to call the scene until it says so itself. */
  readonly title?: string;
  /** Address of a picture to show until the scene has one of its own. */
  readonly poster?: string | null;
  /** For a page that is a player alone: all keys and the wheel are the player's. Left out in a page with other things. */
  readonly page?: WholePage;
}

const LABEL = "Scene; drag or use the arrow keys to turn, click to play or pause";

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
  #transport: Transport | null = null;

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
    this.controls = options.controls ?? true;
    this.poster = options.poster ?? null;
    this.root.classList.toggle("whole-page", page !== undefined);
    this.root.append(this.#stage, this.#poster, this.#notices.node, this.#controls);
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
    this.#transport = new Transport(player, manifest);
    const round = { class: "round small", title: "All scenes", "aria-label": "All scenes" };
    const button = (label: string, path: string, onclick: () => void) =>
      element(
        "button",
        { type: "button", class: "round small", title: label, "aria-label": label, onclick },
        icon(path),
      );
    const bar = element(
      "header",
      { class: "top-bar" },
      page ? element("a", { ...round, href: page.home }, icon(BACK)) : null,
      this.#title,
      new CameraMenu(player).node,
      this.#headset.node,
      button("Statistics (S)", STATS, () => this.#stats.toggle()),
      // Where the browser has it at all: on a phone of Apple only videos can fill the screen.
      "requestFullscreen" in this.#host ? button("Full screen (F)", FULLSCREEN, () => this.toggleFullscreen()) : null,
    );
    this.#controls.replaceChildren(bar, this.#stats.node, this.#transport.node);
  }

  #obey(): void {
    const { page } = this.#options;
    const { player, root } = this;
    const signal = player.disposed;
    const keys = page ? window : root;
    const gestures = {
      keys,
      wheelZooms: () => page !== undefined || root.matches(":focus-within"),
      onTap: () => this.#transport?.toggle(),
    };
    listenForGestures(this.#stage, player.camera, gestures, signal);
    listenForKeys(keys, (event, control) => this.#press(event, control), signal);
    new IdleHiding(root, keys, () => !player.paused, signal);
  }

  #press(event: KeyboardEvent, control: EventTarget): void {
    const transport = this.#transport;
    if (!transport || control instanceof HTMLSelectElement) return;
    // Space presses the button that has the focus.
    if (event.key === " " && control instanceof HTMLButtonElement) return;
    const actions: Readonly<Record<string, () => void>> = {
      " ": () => transport.toggle(),
      k: () => transport.toggle(),
      l: () => transport.toggleLoop(),
      s: () => this.#stats.toggle(),
      f: () => this.toggleFullscreen(),
      ",": () => transport.step(-1),
      ".": () => transport.step(1),
    };
    const action = actions[event.key.toLowerCase()];
    if (!action) return;
    event.preventDefault();
    action();
  }
}
