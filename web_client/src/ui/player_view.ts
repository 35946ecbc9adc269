/** A player with its controls, inside one element of a page, isolated from the page in both directions. */

import { listenForGestures } from "../camera/gestures";
import { element } from "../dom/element";
import { adoptStyle } from "../dom/shadow_style";
import { HgsPlayer } from "../player/hgs_player";
import type { Bookmarks } from "./bookmarks";
import type { Commands } from "./commands";
import { listenForKeys, mayBeObeyed } from "./key_listener";
import { LatePart } from "./late_part";
import { Notices } from "./notices";
import css from "./player.css?inline";
import type { PlayerControls } from "./player_controls";
import type { PlayerViewOptions } from "./player_view_options";
import { pauseOutOfSight, togglePlaying } from "./playing";
import { steering } from "./steering";

const LABEL = "Scene; drag to turn, click to play or pause, press ? for all keys";

export class PlayerView {
  readonly player: HgsPlayer;
  /** The root element; keys pressed while the focus is inside are the player's. */
  readonly root = element("div", { class: "player" });
  readonly #options: PlayerViewOptions;
  readonly #host: HTMLElement;
  readonly #stage = element("div", { class: "stage", role: "img", tabindex: 0, "aria-label": LABEL });
  readonly #poster: HTMLImageElement = element("img", {
    class: "poster",
    alt: "",
    hidden: true,
    onload: () =>
      this.#poster.style.setProperty("--shape", `${this.#poster.naturalWidth / this.#poster.naturalHeight}`),
  });
  readonly #controls = element("div", { class: "controls" });
  readonly #title: HTMLElement;
  readonly #notices: Notices;
  readonly #commands: LatePart<Commands>;
  readonly #bars: LatePart<PlayerControls>;
  readonly #panels = element("div"); // panels of commands
  readonly #settings = element("button", { "aria-expanded": "false" });
  readonly #keys: EventTarget;
  readonly #bookmarks: Bookmarks;

  /**
   * Create a player in an element.
   *
   * @param host gets a shadow root, unless it has an open one that is empty.
   */
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
    this.#bars = new LatePart(
      () => this.#loadControls(),
      (message) => this.fail(message),
      signal,
    );
    this.poster = options.poster ?? null;
    this.root.classList.toggle("whole-page", page !== undefined);
    this.root.append(this.#stage, this.#poster, this.#notices.node, this.#controls);
    const shadow = host.shadowRoot ?? host.attachShadow({ mode: "open" });
    adoptStyle(shadow, css);
    shadow.replaceChildren(this.root);
    this.controls = options.controls ?? true;
    this.#follow();
    if (!exact) this.#obey();
  }

  /** Whether controls are shown. */
  get controls(): boolean {
    return !this.#controls.hidden;
  }

  set controls(shown: boolean) {
    this.#controls.hidden = !shown || (this.#options.exact ?? false);
    if (!this.#controls.hidden) this.#bars.use((bars) => this.#showControls(bars));
  }

  /** Address of the picture before the scene's first one. */
  set poster(address: string | null) {
    // A page may have painted it on the host before the player existed.
    const painted = getComputedStyle(this.#host).backgroundImage.includes("url(");
    if (address && !painted) this.#poster.src = address;
    else this.#poster.removeAttribute("src");
    this.#showPoster();
  }

  /** The scene's title, over the picture. */
  set title(title: string) {
    this.#title.textContent = title;
  }

  /** Enter or leave full screen; shows an error if that fails. */
  toggleFullscreen(): void {
    import("./full_screen") // present since its button or key is
      .then(({ toggleFullscreen }) => toggleFullscreen(this.#host))
      .catch((error: Error) => this.#notices.fail(error.message));
  }

  /** Show an error in the player, one line for people. */
  fail(message: string): void {
    this.#notices.fail(message);
  }

  /** Stop and release everything; the host stays, empty. */
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
        this.#bars.here?.clear();
        this.root.classList.add("blank");
        this.#showPoster();
        notices.begin();
      },
      listen,
    );
    player.addEventListener(
      "manifest",
      ({ detail }) => {
        if (detail.title) this.#title.textContent = detail.title;
        if (this.#bars.here) this.#showControls(this.#bars.here);
      },
      listen,
    );
    player.addEventListener("firstpicture", () => this.#showPoster(), listen);
    player.addEventListener(
      "frame",
      () => {
        const stats = player.statistics;
        if (!stats) return;
        notices.update(stats, player.stalled);
        this.root.classList.toggle("blank", stats.contextLost || stats.firstFrame === null);
        this.#bars.here?.update();
      },
      listen,
    );
    player.addEventListener(
      "error",
      ({ detail }) => {
        // biome-ignore lint/suspicious/noConsole: the player has plain words for it; this is the cause
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

  #showControls(bars: PlayerControls): void {
    const { manifest } = this.player;
    if (manifest) bars.show(manifest);
  }

  async #loadControls(): Promise<PlayerControls> {
    const { PlayerControls } = await import("./player_controls"); // not needed for the first picture
    return new PlayerControls(this.player, {
      bookmarks: this.#bookmarks,
      root: this.root,
      place: this.#controls,
      title: this.#title,
      settings: this.#settings,
      panels: this.#panels,
      keys: this.#keys,
      page: this.#options.page,
      commands: this.#commands,
      toggleFullscreen: "requestFullscreen" in this.#host ? () => this.toggleFullscreen() : null,
    });
  }

  async #loadCommands(): Promise<Commands> {
    const { Commands } = await import("./commands"); // needed for keys and settings
    const { page } = this.#options;
    return new Commands(this.player, {
      bookmarks: this.#bookmarks,
      keep: (bookmarks) => page?.keep?.(bookmarks),
      root: this.root,
      place: this.#panels,
      button: this.#settings,
      keys: this.#keys,
      link: page?.link,
      tools: page?.tools,
      toggleFullscreen: () => this.toggleFullscreen(),
      fail: (text) => this.fail(text),
      marked: () => this.#bars.here?.mark(),
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
    const pressed = (event: KeyboardEvent) => {
      if (!commands.here) {
        if (!mayBeObeyed(event)) return;
        event.preventDefault(); // the key's command is not loaded yet
      }
      commands.use((all) => all.press(event));
    };
    const ignores = (event: KeyboardEvent, control: EventTarget) =>
      player.manifest === null ||
      control instanceof HTMLSelectElement ||
      ([" ", "Enter"].includes(event.key) && control instanceof HTMLButtonElement); // the key presses the button
    listenForKeys(this.#keys, pressed, ignores, signal);
  }
}
