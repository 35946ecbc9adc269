/** The loudness of a host's scene, and events for its sound: a host's events are not those of the page. */

import type { Manifest } from "../codec/types";
import type { PlayerProblem, SoundOptions } from "../player/hgs_player_events";
import type { StreamedScene } from "../scene/streamed_scene";
import type { SoundingPlayer } from "../sound/scene_sound";

export interface HostSoundEvents {
  /** Volume or muting has changed. */
  changed(): void;
  failed(problem: PlayerProblem): void;
}

export class HostSound extends EventTarget implements SoundingPlayer {
  #muted: boolean;
  #volume: number;

  constructor(
    options: SoundOptions,
    readonly scene: Pick<StreamedScene, "manifest" | "playback" | "source">,
    readonly gone: AbortSignal,
    readonly events: HostSoundEvents,
  ) {
    super();
    this.#muted = options.muted ?? false;
    this.#volume = within(options.volume ?? 1);
    this.addEventListener("error", (event) => events.failed((event as CustomEvent<PlayerProblem>).detail));
  }

  get manifest(): Manifest | null {
    return this.scene.manifest;
  }

  get muted(): boolean {
    return this.#muted;
  }

  set muted(muted: boolean) {
    this.#muted = muted;
    this.#changed();
  }

  get volume(): number {
    return this.#volume;
  }

  set volume(volume: number) {
    this.#volume = within(volume);
    this.#changed();
  }

  /** Play the scene's sound, too, from now on. */
  async listen(): Promise<void> {
    try {
      const { SceneSound } = await import("../sound/scene_sound"); // not needed for most scenes
      if (!this.gone.aborted) new SceneSound(this, this.scene, this.gone);
      this.events.changed();
    } catch (error) {
      this.events.failed({ message: "The scene plays without its sound.", cause: String(error) });
    }
  }

  /** The host has drawn a frame. */
  framed(): void {
    this.dispatchEvent(new Event("frame"));
  }

  #changed(): void {
    this.dispatchEvent(new Event("volumechange"));
    this.events.changed();
  }
}

const within = (volume: number): number => Math.min(1, Math.max(0, volume));
