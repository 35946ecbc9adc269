/**
 * `<hgs-player>`: a scene in a page, as `<video>` is a film. Attributes, properties, methods and events have the names
 * and meanings of HTMLMediaElement where it has them.
 */

import { adoptStylesAgain } from "../dom/shadow_style";
import type { HgsPlayer } from "../player/hgs_player";
import type { Beginning, HgsPlayerEvents } from "../player/hgs_player_events";
import { PlayerView } from "../ui/player_view";

/** The player's events, which the element repeats under the same names. */
const EVENTS: readonly (keyof HgsPlayerEvents)[] = [
  "loadstart",
  "manifest",
  "firstpicture",
  "ready",
  "play",
  "pause",
  "stalled",
  "playing",
  "timeupdate",
  "seeked",
  "ended",
  "ratechange",
  "volumechange",
  "viewchange",
  "error",
];

/** Properties that a page may have set before the element was defined. */
const PROPERTIES = [
  "src",
  "poster",
  "autoplay",
  "controls",
  "loop",
  "currentTime",
  "playbackRate",
  "muted",
  "volume",
  "subjectOnly",
] as const;

// The package can be imported where there is no HTMLElement: by servers that render pages. A site's own player is not.
export class HgsPlayerElement extends ((import.meta.env.MODE === "site"
  ? HTMLElement
  : (globalThis.HTMLElement ?? Object)) as typeof HTMLElement) {
  static readonly observedAttributes = ["src", "poster", "controls", "loop", "muted", "subject-only"];

  readonly #view = new PlayerView(this, { controls: false });
  #shown: string | null = null; // address of the loaded scene
  #loads = false; // a load is scheduled
  #left: (Beginning & { readonly src: string; time: number }) | null = null; // the state at its removal from the page

  constructor() {
    super();
    for (const type of EVENTS) {
      this.player.addEventListener(type, (event: Event) => {
        this.dispatchEvent(new CustomEvent(type, { detail: (event as CustomEvent).detail }));
      });
    }
  }

  /** The element's player, with its camera, statistics and pictures. */
  get player(): HgsPlayer {
    return this.#view.player;
  }

  /**
   * Address of the scene: a manifest.json or its folder, a server's page of it, or a stream. Reflects the attribute.
   */
  get src(): string {
    return this.getAttribute("src") ?? "";
  }

  set src(src: string) {
    this.setAttribute("src", src);
  }

  /** Address of the picture until the scene's first one. Reflects the attribute. */
  get poster(): string {
    return this.getAttribute("poster") ?? "";
  }

  set poster(poster: string) {
    this.setAttribute("poster", poster);
  }

  /**
   * Whether the scene plays as soon as it is ready, unless the visitor's system asks for less motion. Reflects the
   * attribute.
   */
  get autoplay(): boolean {
    return this.hasAttribute("autoplay");
  }

  set autoplay(autoplay: boolean) {
    this.toggleAttribute("autoplay", autoplay);
  }

  /** Whether controls are shown. Reflects the attribute. */
  get controls(): boolean {
    return this.hasAttribute("controls");
  }

  set controls(controls: boolean) {
    this.toggleAttribute("controls", controls);
  }

  /** Whether the scene begins again at its end. Reflects the attribute. */
  get loop(): boolean {
    return this.hasAttribute("loop");
  }

  set loop(loop: boolean) {
    this.toggleAttribute("loop", loop);
  }

  /** Seconds on the scene's clock. */
  get currentTime(): number {
    return this.#left?.time ?? this.player.currentTime;
  }

  set currentTime(time: number) {
    if (this.#left) this.#left.time = time;
    else this.player.currentTime = time;
  }

  /** Seconds; NaN until the manifest is there. */
  get duration(): number {
    return this.player.duration;
  }

  get paused(): boolean {
    return this.player.paused;
  }

  get ended(): boolean {
    return this.player.ended;
  }

  /** Scene seconds per second, in (0, 16]. */
  get playbackRate(): number {
    return this.player.playbackRate;
  }

  set playbackRate(rate: number) {
    this.player.playbackRate = rate;
  }

  /** Whether the sound is muted; the attribute is the initial state. */
  get muted(): boolean {
    return this.player.muted;
  }

  set muted(muted: boolean) {
    this.player.muted = muted;
  }

  /** Loudness, from 0 to 1. */
  get volume(): number {
    return this.player.volume;
  }

  set volume(volume: number) {
    this.player.volume = volume;
  }

  /**
   * Whether only moving splats are drawn; set null for the scene's own choice. The attribute is the initial state,
   * `"false"` to begin with all.
   */
  get subjectOnly(): boolean {
    return this.player.subjectOnly;
  }

  set subjectOnly(asked: boolean | null) {
    this.player.subjectOnly = asked;
  }

  play(): void {
    this.player.play();
  }

  pause(): void {
    this.player.pause();
  }

  /** Load `src` anew, from the attributes `time` (seconds) and `camera` (a name) where they are given. */
  load(): void {
    this.#loads = false;
    this.#shown = this.getAttribute("src");
    if (this.#shown === null) {
      this.player.unload();
      return;
    }
    const left = this.#left?.src === this.#shown ? this.#left : null;
    this.#left = null;
    if (!left && this.autoplay && !matchMedia("(prefers-reduced-motion: reduce)").matches) this.player.play();
    const beginning = left ?? { time: this.#seconds("time"), camera: this.getAttribute("camera") };
    this.player.load(this.#shown, beginning).catch(() => {}); // the event `error` reports failures
  }

  connectedCallback(): void {
    for (const name of PROPERTIES) this.#adopt(name);
    if (this.#shown !== this.getAttribute("src")) this.#loadSoon();
  }

  /**
   * Release everything on removal from the page. An element that is inserted again loads again, and continues where it
   * was.
   */
  disconnectedCallback(): void {
    queueMicrotask(() => {
      if (this.isConnected) return; // it was moved
      const { currentTime, loopRange, manifest } = this.player;
      const { name, view } = this.player.camera;
      if (manifest && this.#shown) this.#left = { src: this.#shown, time: currentTime, camera: name, view, loopRange };
      this.player.unload();
      this.#shown = null;
    });
  }

  adoptedCallback(): void {
    if (this.shadowRoot) adoptStylesAgain(this.shadowRoot);
  }

  attributeChangedCallback(name: string, _: string | null, value: string | null): void {
    if (name === "src") this.#loadSoon();
    else if (name === "poster") this.#view.poster = value;
    else if (name === "subject-only") this.subjectOnly = value === null ? null : value !== "false";
    else if (name === "controls") this.#view.controls = value !== null;
    else this.player[name as "muted" | "loop"] = value !== null;
  }

  /** Load once all attributes are set. */
  #loadSoon(): void {
    if (this.#loads || !this.isConnected) return;
    this.#loads = true;
    queueMicrotask(() => {
      if (this.#loads && this.isConnected) this.load();
      this.#loads = false;
    });
  }

  #seconds(attribute: string): number | null {
    const text = this.getAttribute(attribute);
    if (text === null) return null;
    const seconds = Number(text);
    if (text.trim() !== "" && Number.isFinite(seconds)) return seconds;
    this.#view.fail(`${attribute}="${text}" is not a number of seconds`);
    return null;
  }

  /** Pass on a value that was set on the element before its definition. */
  #adopt(name: (typeof PROPERTIES)[number]): void {
    if (!Object.hasOwn(this, name)) return;
    const value = this[name];
    delete (this as Partial<Record<typeof name, unknown>>)[name];
    Object.assign(this, { [name]: value });
  }
}
