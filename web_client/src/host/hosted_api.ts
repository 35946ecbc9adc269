/** The common interface of all hosts' scenes: playing, and their own choices. */

import type { Manifest } from "../codec/types";
import { type Asked, MediaApi, withMembers } from "../player/media_api";
import type { Playback } from "../scene/playback";
import type { HostedStream } from "./hosted_stream";
import type { HgsSceneEvents } from "./scene_options";

export abstract class HostedApi extends MediaApi {
  /** @internal */
  protected abstract readonly hosted: HostedStream<never>;
  protected abstract override emit<K extends keyof HgsSceneEvents>(type: K, detail: HgsSceneEvents[K]): void;

  /** The scene's manifest; null until it has arrived. */
  get manifest(): Manifest | null {
    return this.hosted.scene.manifest;
  }

  /**
   * Whether a scene with sound is muted. One that begins before the visitor has touched the page mutes itself, because
   * no browser allows sound then.
   */
  get muted(): boolean {
    return this.hosted.sound.muted;
  }

  set muted(muted: boolean) {
    this.hosted.sound.muted = muted;
  }

  /** Loudness, from 0 to 1; other numbers are clamped. */
  get volume(): number {
    return this.hosted.sound.volume;
  }

  set volume(volume: number) {
    this.hosted.sound.volume = volume;
  }

  /** Whether only moving splats are drawn; set null for the scene's own choice. */
  get subjectOnly(): boolean {
    return this.hosted.scene.subjectOnly;
  }

  set subjectOnly(asked: boolean | null) {
    this.hosted.scene.subjectOnly = asked;
    this.changed();
  }

  protected get asked(): Asked {
    return this.hosted.asked;
  }

  protected get playback(): Playback | null {
    return this.hosted.scene.playback;
  }

  protected changed(): void {
    this.emit("change", null);
  }

  protected settled(): Promise<boolean> {
    return this.hosted.settled();
  }
}

/** A class of a host's objects that is extended by the members of `HostedApi`. */
export function withHostedApi<B extends abstract new (...args: never[]) => object>(
  Base: B,
  // biome-ignore lint/suspicious/noExplicitAny: TypeScript requires it of a class with another one's members
): B & (abstract new (...args: any[]) => HostedApi) {
  return withMembers(withMembers(Base, MediaApi), HostedApi) as unknown as ReturnType<typeof withHostedApi<B>>;
}
