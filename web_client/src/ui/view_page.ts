/** The page that plays a scene. */

import { listenForGestures } from "../camera/gestures";
import { ScenePlayer } from "../player/player";
import type { Pixels } from "../renderer/shot";
import { SceneStream } from "../source/scene_stream";
import { streamUrl } from "../source/stream_url";
import { CameraMenu } from "./camera_menu";
import { element, icon } from "./element";
import { BACK, FULLSCREEN, STATS } from "./icons";
import { IdleHiding } from "./idle_hiding";
import { Notices } from "./notices";
import { StatsPanel } from "./stats_panel";
import { Transport } from "./transport";
import { parseViewParameters, type ViewParameters } from "./view_parameters";
import { Viewpoint } from "./viewpoint";

/** What the page offers to scripts, such as tests: `window.hgs`. */
export interface ViewerHandle {
  /** Resolves when everything alive at the first time has arrived, been sorted and drawn; rejects if it cannot. */
  readonly ready: Promise<void>;
  readonly state: Readonly<Record<string, unknown>>;
  /** Go to a time, seconds; resolves when all of it is drawn. */
  seek(time: number): Promise<void>;
  play(): void;
  pause(): void;
  /** The picture, RGBA from the top row; in floats without the canvas's rounding if asked. */
  readPixels(options?: { float?: boolean }): Promise<Pixels>;
}

declare global {
  interface Window {
    hgs?: ViewerHandle;
  }
}

export function showViewPage(root: HTMLElement, scene: string): void {
  document.title = `${scene} · HGS`;
  root.className = "view-page";
  const notices = new Notices();
  try {
    new ViewPage(root, scene, parseViewParameters(location.search), notices);
  } catch (error) {
    root.replaceChildren(notices.node);
    notices.fail(error instanceof Error ? error.message : String(error));
  }
}

class ViewPage {
  readonly #abort = new AbortController();
  readonly #canvas = element("canvas", {
    class: "picture",
    role: "img",
    "aria-label": "Scene; drag or use the arrow keys to turn, click to play or pause",
  });
  readonly #title = element("h1");
  readonly #player: ScenePlayer;
  readonly #viewpoint: Viewpoint;
  readonly #stats: StatsPanel;
  #transport: Transport | null = null;
  #fail: (error: Error) => void = () => {};

  constructor(
    readonly root: HTMLElement,
    scene: string,
    readonly parameters: ViewParameters,
    readonly notices: Notices,
  ) {
    const { signal } = this.#abort;
    this.#title.textContent = scene;
    root.replaceChildren(this.#canvas, notices.node);
    this.#viewpoint = new Viewpoint(this.#canvas, parameters, () => this.#player.invalidate(), signal);
    this.#player = new ScenePlayer({
      canvas: this.#canvas,
      source: (events, playhead) => new SceneStream(streamUrl(scene), events, playhead),
      time: parameters.time,
      playing: !(parameters.paused ?? matchMedia("(prefers-reduced-motion: reduce)").matches),
      antialiased: parameters.antialiased,
      view: () => this.#viewpoint.view(),
      onManifest: (manifest) => {
        this.#viewpoint.begin(manifest);
        document.title = `${manifest.title || scene} · HGS`;
        this.#title.textContent = manifest.title || scene;
        this.#transport = new Transport(this.#player, manifest);
        if (!parameters.exact) this.#showControls(manifest.cameras.map((camera) => camera.name));
      },
      onFrame: () => {
        const { stats, clock } = this.#player;
        notices.update(stats, clock?.stalled ?? false);
        root.classList.toggle("lost", stats.contextLost);
        this.#transport?.update();
      },
      onError: (message, cause) => {
        // biome-ignore lint/suspicious/noConsole: the page says it in plain words; this is the cause
        console.error(cause);
        notices.fail(message);
        this.#fail(new Error(cause));
      },
    });
    this.#stats = new StatsPanel(this.#player, this.#canvas, signal);
    this.#offerHandle();
    if (!parameters.exact) {
      listenForGestures(this.#canvas, this.#viewpoint, () => this.#transport?.toggle(), signal);
    }
    addEventListener("pagehide", () => this.#leave(), { signal });
  }

  #showControls(cameras: readonly string[]): void {
    const { signal } = this.#abort;
    const transport = this.#transport;
    if (!transport) return;
    const cameraMenu = new CameraMenu(this.#viewpoint, cameras);
    const button = (label: string, path: string, onclick: () => void, hidden = false) =>
      element(
        "button",
        { type: "button", class: "round small", title: label, "aria-label": label, hidden, onclick },
        icon(path),
      );
    const bar = element(
      "header",
      { class: "top-bar" },
      element("a", { class: "round small", href: "/", title: "All scenes", "aria-label": "All scenes" }, icon(BACK)),
      this.#title,
      cameraMenu.node,
      button("Statistics (S)", STATS, () => this.#stats.toggle()),
      button("Full screen (F)", FULLSCREEN, () => this.#toggleFullscreen(), !document.fullscreenEnabled),
    );
    this.root.append(bar, this.#stats.node, transport.node);
    addEventListener("keydown", (event) => this.#press(event, transport), { signal });
    new IdleHiding(this.root, () => this.#player.clock?.playing ?? false, signal);
  }

  #press(event: KeyboardEvent, transport: Transport): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const target = event.target as HTMLElement;
    if (target instanceof HTMLSelectElement) return;
    // Space presses the button that has the focus.
    if (event.key === " " && target instanceof HTMLButtonElement) return;
    const actions: Readonly<Record<string, () => void>> = {
      " ": () => transport.toggle(),
      k: () => transport.toggle(),
      l: () => transport.toggleLoop(),
      s: () => this.#stats.toggle(),
      f: () => this.#toggleFullscreen(),
      ",": () => transport.step(-1),
      ".": () => transport.step(1),
    };
    const action = actions[event.key.toLowerCase()];
    if (!action) return;
    event.preventDefault();
    action();
  }

  #toggleFullscreen(): void {
    if (document.fullscreenElement) void document.exitFullscreen();
    else void document.documentElement.requestFullscreen?.().catch(() => {}); // refused: the page stays as it is
  }

  #offerHandle(): void {
    const player = this.#player;
    const canvas = this.#canvas;
    const failed = new Promise<never>((_, reject) => {
      this.#fail = reject;
    });
    const settled = () => Promise.race([player.settled(), failed]);
    const ready = settled();
    ready.catch(() => {}); // shown on the page already
    window.hgs = {
      ready,
      get state() {
        const clock = player.clock;
        return {
          time: clock?.time ?? null,
          playing: clock?.playing ?? false,
          stalled: clock?.stalled ?? false,
          width: canvas.width,
          height: canvas.height,
          ...player.stats,
        };
      },
      seek: (time) => {
        player.seek(time);
        return settled();
      },
      play: () => player.play(),
      pause: () => player.pause(),
      readPixels: async (options = {}) => {
        const pixels = player.readPixels(options.float);
        if (!pixels) throw new Error("nothing has been drawn yet");
        return pixels;
      },
    };
  }

  #leave(): void {
    this.#abort.abort();
    this.#player.dispose();
    delete window.hgs;
  }
}
