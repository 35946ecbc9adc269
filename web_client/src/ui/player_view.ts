/** A player with its controls, inside one element of a page: nothing of it reaches the page, and nothing of the page reaches it. */

import { listenForGestures } from "../camera/gestures";
import type { Manifest } from "../codec/types";
import { HgsPlayer } from "../player/hgs_player";
import type { Bookmarks } from "./bookmarks";
import type { Commands } from "./commands";
import { element, icon } from "./element";
import { toggleFullscreen } from "./full_screen";
import { offerHeadset } from "./headset_offer";
import { BACK, FULLSCREEN, SETTINGS } from "./icons";
import { IdleHiding } from "./idle_hiding";
import { listenForKeys, mayBeObeyed } from "./key_listener";
import { LatePart } from "./late_part";
import { Notices } from "./notices";
import { pauseOutOfSight } from "./out_of_sight";
import css from "./player.css?inline";
import { adoptStyle } from "./player_style";
import type { PlayerViewOptions } from "./player_view_options";
import { togglePlaying } from "./playing";
import { steering } from "./steering";
import { Transport } from "./transport";

const LABEL = "Scene; drag to turn, click to play or pause, press ? for all keys";

const button = (label: string, path: string, onclick: () => void) =>
  element("button", { type: "button", class: "round", title: label, "aria-label": label, onclick }, icon(path));

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
  readonly #commands: LatePart<Commands>;
  readonly #panels = element("div"); // that commands open
  readonly #headset: HTMLElement;
  readonly #settings = button("Settings", SETTINGS, () => this.#commands.use((all) => all.toggleSettings()));
  readonly #keys: EventTarget;
  readonly #bookmarks: Bookmarks;
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
    const signal = this.player.disposed;
    this.#keys = page ? window : this.root;
    this.#bookmarks = { times: [...(options.bookmarks ?? [])].sort((a, b) => a - b) };
    this.#commands = new LatePart(
      () => this.#loadCommands(),
      (message) => this.fail(message),
      signal,
    );
    this.#settings.setAttribute("aria-expanded", "false");
    this.controls = options.controls ?? true;
    this.poster = options.poster ?? null;
    this.root.classList.toggle("whole-page", page !== undefined);
    this.root.append(this.#stage, this.#poster, this.#notices.node, this.#controls);
    const shadow = host.shadowRoot ?? host.attachShadow({ mode: "open" });
    adoptStyle(shadow, css);
    this.#headset = offerHeadset(this.player, shadow);
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
    this.#transport = new Transport(player, this.#bookmarks);
    const bar = element(
      "header",
      { class: "top-bar" },
      page
        ? element("a", { class: "round", title: "All scenes", "aria-label": "All scenes", href: page.home }, icon(BACK))
        : null,
      this.#title,
      this.#headset,
      this.#settings,
      // Where the browser has it at all: on a phone of Apple only videos can fill the screen.
      "requestFullscreen" in this.#host ? button("Full screen (F)", FULLSCREEN, () => this.toggleFullscreen()) : null,
    );
    this.#controls.replaceChildren(bar, this.#panels, this.#transport.node);
    this.#transport.timeline.mark();
    if (manifest.audio) void this.#showSound(this.#transport);
  }

  /** A player that cannot load the controls is as it was; the scene's sound fails in the same way, and says so. */
  async #showSound({ node }: Transport): Promise<void> {
    const controls = await import("./sound_controls").catch(() => null);
    controls?.addSoundControls(this.player, node);
  }

  async #loadCommands(): Promise<Commands> {
    const { Commands } = await import("./commands"); // for those who press a key or open the settings
    const { page } = this.#options;
    return new Commands(this.player, {
      bookmarks: this.#bookmarks,
      keep: (bookmarks) => page?.keep?.(bookmarks),
      root: this.root,
      place: this.#panels,
      button: this.#settings,
      keys: this.#keys,
      link: page?.link,
      crop: page?.crop,
      toggleFullscreen: () => this.toggleFullscreen(),
      fail: (text) => this.fail(text),
      marked: () => this.#transport?.timeline.mark(),
    });
  }

  #obey(): void {
    const { page } = this.#options;
    const { player, root } = this;
    const signal = player.disposed;
    const commands = this.#commands;
    const fly = {
      get active() {
        return commands.here?.fly.active ?? false;
      },
    };
    const gestures = {
      wheelZooms: () => page !== undefined || root.matches(":focus-within"),
      onTap: () => togglePlaying(player),
    };
    listenForGestures(this.#stage, steering(player.camera, fly), gestures, signal);
    const heard = (event: KeyboardEvent) => {
      if (!commands.here) {
        if (!mayBeObeyed(event)) return;
        event.preventDefault(); // until it is known what the key does
      }
      commands.use((all) => all.press(event));
    };
    const ignores = (event: KeyboardEvent, control: EventTarget) =>
      this.#transport === null ||
      control instanceof HTMLSelectElement ||
      ([" ", "Enter"].includes(event.key) && control instanceof HTMLButtonElement); // which it presses
    listenForKeys(this.#keys, heard, ignores, signal);
    new IdleHiding(root, this.#keys, () => !player.paused, signal);
  }
}
