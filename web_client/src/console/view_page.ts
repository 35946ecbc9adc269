/** The page that plays a scene: a player, the address's parameters, the title, and a handle for scripts. */

import { element } from "../dom/element";
import type { KeyFrameTool } from "../keyframes/key_frame_tool";
import type { HgsPlayer } from "../player/hgs_player";
import { ApiError, getScene } from "../protocol/api";
import { KEY_NEEDED, siteUrl } from "../protocol/http";
import type { Quality } from "../renderer/fineness";
import { floatPixels } from "../renderer/float_pixels";
import type { Pixels } from "../renderer/shot";
import { PlayerView } from "../ui/player_view";
import type { PageTools, WholePage } from "../ui/player_view_options";
import { linkWithBookmarks, linkWithKeys, sharedLink } from "../ui/shared_view";
import { parseViewParameters, type ViewParameters } from "./view_parameters";

/** The page's interface for scripts, such as tests: `window.hgs`. */
export interface ViewerHandle {
  /** Resolves when everything visible at the first time has arrived, been sorted and drawn; rejects on failure. */
  readonly ready: Promise<void>;
  readonly state: Readonly<Record<string, unknown>>;
  /** The quality as in the settings: `auto` draws motion as finely as this device can, `high` always at its best. */
  quality: Quality;
  /** Seek to a time, seconds; resolves when everything is drawn. */
  seek(time: number): Promise<void>;
  play(): void;
  pause(): void;
  /** The picture, RGBA from the top row; optionally in floats without the canvas's rounding. */
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
  const path = keyFrames();
  const page: WholePage = {
    home: siteUrl(""),
    reload: () => location.reload(),
    link: (shared) => sharedLink(location.href, shared),
    tools: {
      path,
      ...(linked() ? {} : editing(scene)),
    },
    keep: (bookmarks) => history.replaceState(null, "", linkWithBookmarks(location.href, bookmarks)),
  };
  // The server has created it, with the scene's poster, if there is one.
  const host = root.querySelector("main") ?? element("main", { class: "player-host" });
  root.replaceChildren(host);
  try {
    play(host, scene, parseViewParameters(location.search), page, path);
  } catch (error) {
    new PlayerView(host, { page }).fail(error instanceof Error ? error.message : String(error));
  }
}

/** Whether the visitor came by a link, which opens a scene and nothing else. */
const linked = (): boolean => new URLSearchParams(location.search).has("link");

/** The tools that make a new scene of this one; they load when first used. */
function editing(scene: string): Pick<PageTools, "crop" | "clean"> {
  const starter = async (player: HgsPlayer) => (await import("./started_edit")).editStarter(scene, player.disposed);
  return {
    crop: async (player, root) => new (await import("../crop/crop_tool")).CropTool(player, root, await starter(player)),
    clean: async (player, root) =>
      new (await import("../clean/clean_tool")).CleanTool(player, root, await starter(player)),
  };
}

type LoadKeyFrames = (player: HgsPlayer, root: HTMLElement) => Promise<KeyFrameTool>;

/** The loader of the one tool for camera paths, with the key frames of the address. */
function keyFrames(): LoadKeyFrames {
  const load: LoadKeyFrames = async (player, root) => {
    const { KeyFrameTool } = await import("../keyframes/key_frame_tool");
    const { keys } = parseViewParameters(location.search);
    const keep = (numbers: readonly number[]) => history.replaceState(null, "", linkWithKeys(location.href, numbers));
    return new KeyFrameTool(player, root, keys, keep);
  };
  let tool: Promise<KeyFrameTool> | null = null;
  return (player, root) => {
    tool ??= load(player, root).catch((error) => {
      tool = null; // the next use tries again
      throw error;
    });
    return tool;
  };
}

function play(
  host: HTMLElement,
  scene: string,
  parameters: ViewParameters,
  page: WholePage,
  path: LoadKeyFrames,
): void {
  const view = new PlayerView(host, {
    ...parameters,
    autoplay: !(parameters.paused ?? matchMedia("(prefers-reduced-motion: reduce)").matches),
    loop: true,
    title: scene,
    page,
  });
  const { player } = view;
  const call = (title: string) => {
    view.title = title;
    document.title = `${title} · HGS`;
  };
  const link = new URLSearchParams(location.search).get("link");
  const query = link === null ? "" : `?link=${encodeURIComponent(link)}`;
  // The server has the latest title, and may require a key; without an answer the manifest's title stays.
  const served = getScene(scene, player.disposed, query).then(
    ({ title }) => title,
    (error: unknown) => {
      if (error instanceof ApiError && error.status === 404) void missing();
      return "";
    },
  );
  player.addEventListener("manifest", ({ detail }) => {
    call(detail.title || scene);
    void served.then((title) => call(title || detail.title || scene));
  });
  const follow = () => {
    path(player, view.root).then(
      (tool) => tool.follow(true),
      (error: Error) => view.fail(error.message),
    );
  };
  if (parameters.keys.length > 0) player.addEventListener("manifest", follow, { once: true });
  player.addEventListener("firstpicture", () => host.classList.remove("poster"));
  const ready = player.load(siteUrl(`view/${scene}${query}`));
  ready.catch(() => {}); // shown on the page already
  window.hgs = handle(player, ready);
  const end = () => {
    view.dispose();
    delete window.hgs;
  };
  async function missing(): Promise<void> {
    end();
    const { showNotFoundPage } = await import("./not_found_page"); // only for lost links
    showNotFoundPage(document.body, page.home, "There is no such scene here", "It may have been deleted.");
  }
  addEventListener("pagehide", end, { once: true });
  // The page that asks for the key takes the place of the player, which would go on connecting behind it.
  addEventListener(KEY_NEEDED, end, { once: true });
}

function handle(player: HgsPlayer, ready: Promise<void>): ViewerHandle {
  return {
    ready,
    get state() {
      return {
        time: player.manifest && player.currentTime,
        playing: player.manifest !== null && !player.paused,
        stalled: player.stalled,
        width: player.width,
        height: player.height,
        ...player.statistics,
      };
    },
    get quality() {
      return player.quality;
    },
    set quality(quality) {
      player.quality = quality;
    },
    seek: (time) => player.seek(time),
    play: () => player.play(),
    pause: () => player.pause(),
    readPixels: async ({ float = false } = {}) => {
      const { scene } = player;
      return float && scene?.shot ? floatPixels(scene.renderer, scene.shot) : player.readPixels();
    },
  };
}
