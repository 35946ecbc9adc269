/** The tool for camera paths: key frames on the time line, and a camera that follows them. */

import { cropViewOf } from "../crop/crop_view";
import { element } from "../dom/element";
import { adoptStyle } from "../dom/shadow_style";
import toolCss from "../dom/tool_panel.css?inline";
import type { HgsPlayer } from "../player/hgs_player";
import type { Viewing } from "../player/viewpoint";
import { axisFor, middleOf } from "./aim";
import { cameraAt, type KeyFrame, keyAt, keysOf, numbersOf, pathDocument, withKey, withoutKey } from "./camera_path";
import css from "./key_frames.css?inline";
import { PathPanel } from "./path_panel";

/** The name of the saved file. */
const FILE = "camera-path.json";

export class KeyFrameTool {
  readonly #panel: PathPanel;
  readonly #marks = element("span", { class: "path-marks" });
  #keys: readonly KeyFrame[];
  #following = false;
  #followed = Number.NaN; // seconds of the last camera on the path
  #placed = Number.NaN; // end of the time line under the marks, seconds

  /**
   * Create the tool.
   *
   * @param root root element of the player, in its shadow root.
   * @param numbers the first key frames' numbers, as in addresses.
   * @param keep is called with the numbers after every change.
   */
  constructor(
    readonly player: HgsPlayer,
    readonly root: HTMLElement,
    numbers: readonly number[],
    readonly keep: (numbers: readonly number[]) => void,
  ) {
    for (const style of [toolCss, css]) adoptStyle(root.getRootNode() as ShadowRoot, style);
    this.#keys = keysOf(numbers);
    this.#panel = new PathPanel({
      add: () => this.#add(),
      remove: (key) => this.#change(withoutKey(this.#keys, key.time)),
      go: (key) => this.#go(key),
      follow: () => this.follow(!this.#following),
      save: () => this.#save(),
      close: () => this.toggle(),
    });
    const listen = { signal: player.disposed };
    player.addEventListener("frame", () => this.#update(), listen);
    const stage = root.querySelector<HTMLElement>(".stage");
    // A hand on the picture is stronger than the path.
    stage?.addEventListener("pointermove", ({ buttons }) => buttons && this.follow(false), listen);
    stage?.addEventListener("wheel", () => this.follow(false), { ...listen, passive: true });
    this.#show();
  }

  /** Whether its panel is shown. */
  get active(): boolean {
    return this.#panel.node.isConnected;
  }

  /** Open or close the panel. */
  toggle(): void {
    if (this.active) {
      this.#panel.node.remove();
      this.root.querySelector<HTMLElement>(".stage")?.focus({ preventScroll: true });
    } else {
      this.root.append(this.#panel.node);
      this.#show();
    }
  }

  /** Begin or end to move the camera along the path as the time goes on. */
  follow(following: boolean): void {
    if (following === this.#following) return;
    this.#following = following && this.#keys.length > 0;
    this.#followed = Number.NaN;
    this.#update();
    this.#show();
  }

  #add(): void {
    const { currentTime, camera } = this.player;
    const viewing = camera.view;
    const seen = this.#viewOf(viewing);
    if (!viewing || !seen) return;
    const { height, fy } = seen.camera;
    const verticalFov = (2 * Math.atan(height / 2 / fy) * 180) / Math.PI;
    const { position } = viewing;
    const target = middleOf(viewing, seen);
    const [key] = keysOf(numbersOf([{ time: currentTime, position, target, verticalFov }]));
    this.#change(withKey(this.#keys, key));
  }

  #change(keys: readonly KeyFrame[]): void {
    this.#keys = keys;
    this.#followed = this.player.currentTime; // the camera stays where it is
    if (keys.length === 0) this.#following = false;
    this.keep(numbersOf(keys));
    this.#show();
  }

  #go(key: KeyFrame): void {
    this.player.currentTime = key.time;
    this.#look(key);
  }

  #save(): void {
    const address = URL.createObjectURL(new Blob([pathDocument(this.#keys)], { type: "application/json" }));
    element("a", { href: address, download: FILE }).click();
    setTimeout(() => URL.revokeObjectURL(address), 60_000); // the browser may read it late
  }

  /** Follow the time; called at every frame of the player. */
  #update(): void {
    const { currentTime } = this.player;
    if (this.#following && currentTime !== this.#followed) {
      this.#followed = currentTime;
      this.#look(cameraAt(this.#keys, currentTime));
    }
    if (this.player.end !== this.#placed)
      this.#show(); // a grown scene changes the places on the time line
    else if (this.#panel.node.isConnected) this.#panel.show(this.#state);
    if (!this.#marks.isConnected) this.root.querySelector(".timeline")?.append(this.#marks);
  }

  #look({ position, target }: KeyFrame): void {
    const { manifest, camera } = this.player;
    if (!manifest) return;
    try {
      camera.view = axisFor({ position, target, up: manifest.up }, (viewing) => this.#viewOf(viewing));
    } catch (error) {
      if (!(error instanceof RangeError)) throw error; // straight up or down: the camera waits
    }
  }

  #viewOf(viewing: Viewing | null) {
    return cropViewOf(this.player, this.root.getBoundingClientRect(), viewing);
  }

  get #state() {
    const { currentTime, start } = this.player;
    return { keys: this.#keys, following: this.#following, here: !!keyAt(this.#keys, currentTime), start };
  }

  #show(): void {
    const { start, duration } = this.player;
    this.#placed = this.player.end;
    this.#panel.show(this.#state);
    this.#marks.replaceChildren(
      ...this.#keys.map(({ time }) => {
        const mark = element("span", { class: "path-mark" });
        mark.style.setProperty("--at", (duration > 0 ? (time - start) / duration : 0).toFixed(4));
        return mark;
      }),
    );
  }
}
