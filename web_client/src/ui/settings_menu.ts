/** The settings menu: quality, camera, speed, repeating, bookmarks, links, pictures, help. */

import { element } from "../dom/element";
import { formatTime } from "../dom/format";
import type { HgsPlayer } from "../player/hgs_player";
import type { Quality } from "../renderer/fineness";
import { type PlayerActions, RATES } from "./player_actions";

const QUALITY_NAMES: Readonly<Record<Quality, string>> = {
  auto: "Auto",
  high: "High",
  medium: "Medium",
  low: "Low",
};

/** The parts beside the menu that it opens and closes. */
export interface MenuSurroundings {
  readonly statisticsShown: boolean;
  toggleStatistics(): void;
  showHelp(): void;
}

export class SettingsMenu {
  readonly node = element("div", { class: "menu", role: "group", "aria-label": "Settings", hidden: true });
  readonly #rate = element("select", { "aria-label": "Speed" });
  readonly #quality = element("select", { "aria-label": "Quality" });
  readonly #camera = element("select", { "aria-label": "Camera" });
  readonly #loop: HTMLButtonElement;
  readonly #fly: HTMLButtonElement;
  readonly #subjectOnly: HTMLButtonElement;
  readonly #statistics: HTMLButtonElement;
  readonly #clear: HTMLButtonElement;
  readonly #marks = element("div", { class: "menu-marks" });
  readonly #gone = new AbortController();

  /** Create the menu for the present scene; `root` is the player's root element, `button` has the menu's open state. */
  constructor(
    readonly player: HgsPlayer,
    readonly actions: PlayerActions,
    readonly view: MenuSurroundings,
    root: HTMLElement,
    readonly button: HTMLElement,
  ) {
    const { camera } = player;
    choose(this.#quality, Object.keys(QUALITY_NAMES) as Quality[], (quality) => QUALITY_NAMES[quality]);
    this.#quality.addEventListener("change", () => {
      player.quality = this.#quality.value as Quality;
    });
    choose(this.#rate, RATES, (rate) => `${rate}×`);
    this.#rate.addEventListener("change", () => {
      actions.rate = Number(this.#rate.value);
    });
    const names = readableCameraNames(camera.names);
    choose(this.#camera, camera.names, (_, i) => names[i]);
    this.#camera.addEventListener("change", () => camera.look(this.#camera.value));

    this.#loop = toggle("Repeat (Shift + L)", () => actions.toggleLoop());
    this.#fly = toggle("Fly (G)", () => actions.toggleFly());
    this.#subjectOnly = toggle("Subject only (H)", () => actions.toggleSubjectOnly());
    this.#statistics = toggle("Statistics (S)", () => view.toggleStatistics());
    this.#clear = command("Clear the repeated part (X)", () => actions.clearLoop());
    const { moves } = actions;
    const link = actions.surroundings.link !== null;
    const { toggleCrop, togglePath, toggleClean } = actions.surroundings;
    this.node.append(
      row("Quality", this.#quality),
      ...(camera.names.length > 0 ? [row("Camera", this.#camera)] : []),
      ...(moves ? [row("Speed", this.#rate)] : []),
      group(
        ...(moves ? [this.#loop] : []),
        this.#fly,
        ...(actions.hasSubject ? [this.#subjectOnly] : []),
        this.#statistics,
        command("Back to the camera (R)", () => actions.resetCamera()),
      ),
      ...(moves
        ? [
            group(
              command("Repeat from here (I)", () => actions.setLoop("from")),
              command("Repeat until here (O)", () => actions.setLoop("to")),
              this.#clear,
              command("Bookmark here (B)", () => actions.toggleBookmark()),
            ),
            this.#marks,
          ]
        : []),
      group(
        ...(link ? [command("Copy link (C)", () => this.#close(() => actions.copyLink()))] : []),
        ...(togglePath ? [command("Camera path (N)", () => this.#close(togglePath))] : []),
        ...(toggleCrop ? [command("Crop (V)", () => this.#close(toggleCrop))] : []),
        ...(toggleClean ? [command("Clean (E)", () => this.#close(toggleClean))] : []),
        command("Save picture (P)", () => this.#close(() => actions.savePicture())),
        command("Keys and gestures (?)", () => this.#close(() => view.showHelp())),
      ),
    );
    this.#closeBeside(root);
    this.update();
  }

  toggle(): void {
    this.#show(this.node.hidden === true);
  }

  /** Show the current choices. */
  update(): void {
    const { player, actions, view } = this;
    this.#quality.value = player.quality;
    this.#rate.value = String(player.playbackRate);
    this.#camera.value = player.camera.name ?? "";
    press(this.#loop, player.loop);
    press(this.#fly, actions.surroundings.fly.active);
    press(this.#subjectOnly, player.subjectOnly);
    press(this.#statistics, view.statisticsShown);
    this.#clear.hidden = player.loopRange === null;
    this.#marks.replaceChildren(
      ...actions.surroundings.bookmarks.times.map((time) => {
        const shown = formatTime(time - player.start);
        const button = command(shown, () => actions.seekTo(time));
        button.setAttribute("aria-label", `To the bookmark at ${shown}`);
        return button;
      }),
    );
  }

  /** Remove the menu: another scene is loading. */
  dispose(): void {
    this.#show(false);
    this.#gone.abort();
  }

  #show(shown: boolean): void {
    this.node.hidden = !shown;
    this.button.setAttribute("aria-expanded", String(shown));
    if (shown) this.update();
  }

  /** Close the menu before an action with a visible effect. */
  #close(then: () => unknown): void {
    this.#show(false);
    this.button.focus();
    then();
  }

  /** Close the menu on Esc and on a press anywhere else. */
  #closeBeside(root: HTMLElement): void {
    const inside = (event: Event) => event.composedPath().some((part) => part === this.node || part === this.button);
    const signal = AbortSignal.any([this.#gone.signal, this.player.disposed]);
    document.addEventListener("pointerdown", (event) => inside(event) || this.#show(false), { signal, capture: true });
    root.addEventListener("focusin", (event) => inside(event) || this.#show(false), { signal });
    root.addEventListener(
      "keydown",
      (event) => {
        if (event.key !== "Escape" || this.node.hidden) return;
        event.preventDefault();
        this.#close(() => {});
      },
      { signal },
    );
  }
}

function choose<T extends string | number>(
  select: HTMLSelectElement,
  values: readonly T[],
  name: (value: T, i: number) => string,
): void {
  select.append(...values.map((value, i) => element("option", { value }, name(value, i))));
}

const row = (label: string, control: HTMLElement) =>
  element("div", { class: "menu-row" }, element("span", { "aria-hidden": "true" }, label), control);

const group = (...children: HTMLElement[]) => element("div", { class: "menu-group" }, ...children);

/** A menu entry; the key in brackets is not a part of its accessible name. */
function command(label: string, onclick: () => void): HTMLButtonElement {
  const [, name, key] = /^(.*?)(?: \((.*)\))?$/.exec(label) as unknown as [string, string, string | undefined];
  return element(
    "button",
    { type: "button", class: "command", onclick },
    element("span", {}, name),
    key ? element("kbd", { "aria-hidden": "true" }, key) : null,
  );
}

function toggle(label: string, onclick: () => void): HTMLButtonElement {
  const button = command(label, onclick);
  button.setAttribute("aria-pressed", "false");
  return button;
}

const press = (button: HTMLButtonElement, pressed: boolean) => button.setAttribute("aria-pressed", String(pressed));

/**
 * The displayed names, in the same order: "cam00" as "Camera 0", "frame_00012.jpg" as "Frame 12", "left-side" as "Left
 * side". Names that would become equal stay unchanged.
 */
export function readableCameraNames(names: readonly string[]): readonly string[] {
  const readable = names.map(readableName);
  return names.map((name, i) => (readable.filter((other) => other === readable[i]).length > 1 ? name : readable[i]));
}

function readableName(name: string): string {
  const words = name
    .replace(/\.(?:jpe?g|png|webp|tiff?|exr|mp4|mov)$/i, "")
    .replace(/[_\s-]+/g, " ")
    .replace(/(\p{L})(\d)/gu, "$1 $2")
    .replace(/\b0+(?=\d)/g, "")
    .replace(/^cam(?=\s|$)/i, "camera")
    .trim();
  return words === "" ? name : words[0].toUpperCase() + words.slice(1);
}
