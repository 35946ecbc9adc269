/** What there is to see and to read of the scene that a player shows. */

import type { Manifest } from "../codec/types";
import type { Pixels } from "../renderer/shot";
import type { Playback } from "../scene/playback";
import type { HgsPlayerListening } from "./hgs_player_events";
import { withMediaApi } from "./media_api";
import type { MountedScene } from "./mounted_scene";
import type { PlayerStats } from "./player_types";
import type { SceneCanvas } from "./scene_canvas";

const Target = EventTarget as new () => HgsPlayerListening & EventTarget;

export abstract class PlayerReadings extends withMediaApi(Target) {
  /** The scene that is there; null without one. */
  protected abstract readonly mounted: MountedScene | null;

  /** What the scene says of itself; null until it has come. */
  get manifest(): Manifest | null {
    return this.mounted?.manifest ?? null;
  }

  /** Of the picture, in its own pixels; 0 without one. */
  get width(): number {
    return this.mounted?.canvas.width ?? 0;
  }

  get height(): number {
    return this.mounted?.canvas.height ?? 0;
  }

  /** The scene that is there, for a loop of frames other than the page's, such as a headset's; null without one. */
  get scene(): SceneCanvas | null {
    return this.mounted?.player ?? null;
  }

  /** Figures of the scene that is there; null without one. */
  get statistics(): PlayerStats | null {
    return this.mounted?.player.stats ?? null;
  }

  /**
   * The picture, RGBA from the top row: sRGB in bytes, or in floats without the canvas's rounding.
   *
   * @throws Error if nothing has been drawn yet.
   */
  readPixels({ float = false } = {}): Pixels {
    return this.#read(float ? "float" : "canvas");
  }

  /**
   * The picture as a file, as finely drawn as it can be, whatever the quality is.
   *
   * @param type such as `image/png` or `image/jpeg`.
   * @throws Error if nothing has been drawn yet.
   */
  async screenshot(type = "image/png"): Promise<Blob> {
    const pixels = this.#read("finest");
    const { pictureFile } = await import("./picture_file"); // few ask for it
    return pictureFile(pixels, type);
  }

  protected get playback(): Playback | null {
    return this.mounted?.player.playback ?? null;
  }

  #read(as: "canvas" | "float" | "finest"): Pixels {
    const pixels = this.mounted?.player.readPixels(as);
    if (!pixels) throw new Error("there is no picture: nothing has been drawn yet, or the graphics context is away");
    return pixels;
  }
}
