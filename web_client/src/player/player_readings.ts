/** The readings of a player: the manifest, pictures and statistics of its scene. */

import type { Manifest } from "../codec/types";
import type { Pixels } from "../renderer/shot";
import type { Playback } from "../scene/playback";
import type { HgsPlayerListening } from "./hgs_player_events";
import { MediaApi, withMembers } from "./media_api";
import type { MountedScene } from "./mounted_scene";
import type { PlayerStats } from "./player_types";
import type { SceneCanvas } from "./scene_canvas";

const Target = EventTarget as new () => HgsPlayerListening & EventTarget;

export abstract class PlayerReadings extends withMembers(Target, MediaApi) {
  /** The present scene; null without one. */
  protected abstract readonly mounted: MountedScene | null;

  /** The scene's manifest; null until it has arrived. */
  get manifest(): Manifest | null {
    return this.mounted?.manifest ?? null;
  }

  /** Width of the picture, in its own pixels; 0 without one. */
  get width(): number {
    return this.mounted?.canvas.width ?? 0;
  }

  get height(): number {
    return this.mounted?.canvas.height ?? 0;
  }

  /** The present scene, for a loop of frames other than the page's, such as a headset's; null without one. */
  get scene(): SceneCanvas | null {
    return this.mounted?.player ?? null;
  }

  /** Statistics of the present scene; null without one. */
  get statistics(): PlayerStats | null {
    return this.mounted?.player.stats ?? null;
  }

  /**
   * The picture as on the canvas: sRGB in RGBA, from the top row.
   *
   * @throws Error if nothing has been drawn yet.
   */
  readPixels(): Pixels {
    return this.#read();
  }

  /**
   * The picture as a file, in the best fineness, independent of the quality.
   *
   * @param type such as `image/png` or `image/jpeg`.
   * @throws Error if nothing has been drawn yet.
   */
  async screenshot(type = "image/png"): Promise<Blob> {
    const pixels = this.#read(0);
    const { pictureFile } = await import("./picture_file"); // rarely used
    return pictureFile(pixels, type);
  }

  protected get playback(): Playback | null {
    return this.mounted?.player.playback ?? null;
  }

  #read(rung?: number): Pixels {
    const pixels = this.mounted?.player.readPixels(rung);
    if (!pixels) throw new Error("there is no picture: nothing has been drawn yet, or the graphics context is away");
    return pixels;
  }
}
