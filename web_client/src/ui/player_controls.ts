/**
 * The bars over a player's picture: title and buttons above, play, timeline and time below. Loaded with the controls.
 */

import "./full_screen"; // ahead of its use: browsers allow full screen only right after a press
import type { Manifest } from "../codec/types";
import { element } from "../dom/element";
import { BACK, FULLSCREEN, SETTINGS } from "../dom/icons";
import { adoptStyle } from "../dom/shadow_style";
import type { HgsPlayer } from "../player/hgs_player";
import { offeredModes } from "../xr/offer";
import type { Bookmarks } from "./bookmarks";
import type { Commands } from "./commands";
import { LatePart } from "./late_part";
import css from "./player_controls.css?inline";
import type { WholePage } from "./player_view_options";
import { dress } from "./round_button";
import { Transport } from "./transport";
import { ViewButtons } from "./view_buttons";

/** The view around the bars. */
export interface ControlledView {
  readonly bookmarks: Bookmarks;
  /** Root element of the player, in its shadow root. */
  readonly root: HTMLElement;
  /** Container of the bars. */
  readonly place: HTMLElement;
  readonly title: HTMLElement;
  /** The button of the settings, with their open state. */
  readonly settings: HTMLElement;
  /** Container of the commands' panels, between the bars. */
  readonly panels: HTMLElement;
  /** Target of the player's key events. */
  readonly keys: EventTarget;
  /** The page with nothing but the player; undefined for others. */
  readonly page: WholePage | undefined;
  readonly commands: LatePart<Commands>;
  /** Null if the browser has no full screen for elements, such as on iPhones, which have it for videos only. */
  readonly toggleFullscreen: (() => void) | null;
}

export class PlayerControls {
  readonly #headset: HTMLElement;
  #transport: Transport | null = null;
  #buttons: ViewButtons | null = null;

  constructor(
    readonly player: HgsPlayer,
    readonly view: ControlledView,
  ) {
    const { root, settings, keys, commands } = view;
    const shadow = root.getRootNode() as ShadowRoot;
    adoptStyle(shadow, css);
    this.#headset = offerHeadset(player, shadow);
    dress(settings, "Settings", SETTINGS);
    settings.addEventListener("click", () => commands.use((all) => all.toggleSettings()));
    new IdleHiding(root, keys, () => !player.paused, player.disposed);
  }

  /** Start with the present scene. */
  show(manifest: Manifest): void {
    const { player, view } = this;
    const { page, commands, toggleFullscreen } = view;
    const transport = new Transport(player, view.bookmarks);
    this.#transport = transport;
    const buttons = new ViewButtons(
      player,
      {
        share: page?.link ? () => commands.use(({ actions }) => void actions.copyLink()) : null,
        recentre: () => commands.use(({ actions }) => actions.resetCamera()),
      },
      page !== undefined,
    );
    this.#buttons = buttons;
    const bar = element(
      "header",
      { class: "top-bar" },
      page ? dress(element("a", { href: page.home }), "All scenes", BACK) : null,
      view.title,
      this.#headset,
      buttons.recentre,
      buttons.share,
      view.settings,
      toggleFullscreen && dress(element("button", { onclick: toggleFullscreen }), "Full screen (F)", FULLSCREEN),
    );
    view.place.replaceChildren(bar, view.panels, transport.node);
    if (buttons.hint) view.place.append(buttons.hint);
    transport.timeline.mark();
    transport.update();
    if (manifest.audio) void this.#showSound(transport);
  }

  /** Show the player's state; called at every frame of the player. */
  update(): void {
    this.#transport?.update();
    this.#buttons?.update();
  }

  /** Show the bookmarks and the repeated stretch. */
  mark(): void {
    this.#transport?.timeline.mark();
  }

  /** Clear the bars: there is no scene any more. */
  clear(): void {
    this.#transport = this.#buttons = null;
    this.view.place.replaceChildren();
  }

  /** A player without these controls works on; the scene's sound fails in the same way, with an error. */
  async #showSound({ node }: Transport): Promise<void> {
    const controls = await import("./sound_controls").catch(() => null);
    controls?.addSoundControls(this.player, node);
  }
}

/** An element that holds the headset buttons once there is a use for them, until the player is disposed of. */
export function offerHeadset(player: HgsPlayer, shadow: ShadowRoot): HTMLElement {
  const place = element("div");
  const { xr } = navigator;
  const buttons = new LatePart(
    async () => {
      const { HeadsetButtons } = await import("./headset_buttons"); // only for visitors with a headset
      return new HeadsetButtons(player, shadow);
    },
    // biome-ignore lint/suspicious/noConsole: no visitor has requested a headset yet
    (message, cause) => console.warn(message, cause),
    player.disposed,
  );
  const offer = async (): Promise<void> => {
    if ((await offeredModes(xr)).length > 0) buttons.use(({ node }) => place.replaceChildren(node));
  };
  void offer();
  xr?.addEventListener("devicechange", () => void offer(), { signal: player.disposed });
  return place;
}

const IDLE = 3000; // ms

export class IdleHiding {
  #timer: ReturnType<typeof setTimeout> | undefined;

  /**
   * Hide the controls while the scene plays without input.
   *
   * @param keys target of the player's key events.
   */
  constructor(
    readonly root: HTMLElement,
    keys: EventTarget,
    readonly playing: () => boolean,
    signal: AbortSignal,
  ) {
    for (const type of ["pointermove", "pointerdown", "focusin"]) {
      root.addEventListener(type, () => this.#wake(), { signal, passive: true });
    }
    keys.addEventListener("keydown", () => this.#wake(), { signal, passive: true });
    signal.addEventListener("abort", () => clearTimeout(this.#timer));
    this.#wake();
  }

  #wake(): void {
    this.root.classList.remove("idle");
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#sleep(), IDLE);
  }

  #sleep(): void {
    const used = this.root.querySelector(
      ".transport :focus-visible, .top-bar :focus-visible, .menu:not([hidden]), dialog[open]",
    );
    if (this.playing() && !used) this.root.classList.add("idle");
    else this.#timer = setTimeout(() => this.#sleep(), IDLE);
  }
}
