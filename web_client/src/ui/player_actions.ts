/** The actions of keys and menu entries on a player and its scene. A line confirms those without a visible effect. */

import type { FlyMode } from "../camera/fly_mode";
import { element } from "../dom/element";
import { formatTime } from "../dom/format";
import { showSwitch } from "../player/fading";
import type { HgsPlayer } from "../player/hgs_player";
import { toggleMuted } from "../sound/muting";
import { type Bookmarks, neighbour, toggled } from "./bookmarks";
import { moves } from "./playing";
import type { SharedView } from "./shared_view";

/** Rates to choose from, scene seconds per second. */
export const RATES = [0.25, 0.5, 0.75, 1, 1.25, 1.5, 2] as const;

/** Step of an arrow key and of j or l, seconds: that of video pages, and no more than a share of a short scene. */
export const seekStep = (duration: number): number => Math.min(5, duration / 10);
export const longSeekStep = (duration: number): number => Math.min(10, duration / 5);

/** The rate a number of steps faster than `rate`, within `RATES`. */
export function rateAfter(rate: number, steps: 1 | -1): number {
  const next = steps === 1 ? RATES.find((other) => other > rate) : RATES.filter((other) => other < rate).at(-1);
  return next ?? rate;
}

/** The parts of the page that actions need beside the player. */
export interface ActionSurroundings {
  readonly fly: FlyMode;
  readonly bookmarks: Bookmarks;
  /** The bookmarks have changed. */
  keep(bookmarks: readonly number[]): void;
  /** Show a confirmation. */
  notify(text: string): void;
  /** Show an error. */
  fail(text: string): void;
  /** A state of the controls has changed. */
  changed(): void;
  /** The address that opens with the shared view; null if the page has none. */
  readonly link: ((shared: SharedView) => string) | null;
  /** Open or close the crop tool; null if the page has none. */
  readonly toggleCrop: (() => void) | null;
  /** Open or close the key frames of a camera path; null if the page has none. */
  readonly togglePath: (() => void) | null;
  /** Open or close the cleaning tool; null if the page has none. */
  readonly toggleClean: (() => void) | null;
}

export class PlayerActions {
  constructor(
    readonly player: HgsPlayer,
    readonly surroundings: ActionSurroundings,
  ) {}

  /** Whether anything moves in the scene. */
  get moves(): boolean {
    return moves(this.player);
  }

  /** Move the playhead, seconds. */
  seekBy(seconds: number): void {
    const { player } = this;
    if (!this.moves) return;
    this.seekTo(Math.max(player.start, Math.min(player.end, player.currentTime + seconds)));
  }

  seekTo(time: number): void {
    this.player.currentTime = time;
    this.surroundings.notify(formatTime(time - this.player.start));
  }

  /** Move the playhead to a share of the scene. */
  jump(share: number): void {
    if (this.moves) this.seekTo(this.player.start + share * this.player.duration);
  }

  set rate(rate: number) {
    this.player.playbackRate = rate;
    this.#done(`Speed ${rate}×`);
  }

  toggleLoop(): void {
    this.player.loop = !this.player.loop;
    this.#done(this.player.loop ? "Repeats" : "Plays once");
  }

  /** Begin or end the repeated stretch at the playhead. */
  setLoop(edge: "from" | "to"): void {
    const { player } = this;
    if (!this.moves) return;
    const now = player.currentTime;
    const [from, to] = player.loopRange ?? [player.start, player.end];
    const range =
      edge === "from"
        ? ([now, to > now ? to : player.end] as const)
        : ([from < now ? from : player.start, now] as const);
    if (!(range[0] < range[1])) {
      this.surroundings.notify("The repeated part must start before it ends");
      return;
    }
    player.loopRange = range;
    const [a, b] = range.map((time) => formatTime(time - player.start));
    this.#done(`Repeats ${a} to ${b}`);
  }

  clearLoop(): void {
    this.player.loopRange = null;
    this.#done("Nothing is repeated");
  }

  toggleBookmark(): void {
    if (!this.moves) return;
    const { currentTime, start } = this.player;
    const { bookmarks, keep } = this.surroundings;
    const times = toggled(bookmarks.times, currentTime);
    const marked = times.length > bookmarks.times.length;
    bookmarks.times = times;
    keep(times);
    this.#done(`${marked ? "Bookmark at" : "No bookmark at"} ${formatTime(currentTime - start)}`);
  }

  goToBookmark(direction: 1 | -1): void {
    const time = neighbour(this.surroundings.bookmarks.times, this.player.currentTime, direction);
    if (time === null) this.surroundings.notify(direction === 1 ? "No later bookmark" : "No earlier bookmark");
    else this.seekTo(time);
  }

  toggleMuted(): void {
    const { player } = this;
    if (player.manifest?.audio) toggleMuted(player);
    else this.surroundings.notify("This scene has no sound");
  }

  toggleFly(): void {
    const { fly } = this.surroundings;
    fly.toggle();
    this.#done(fly.active ? "Flying: W A S D, Q and E; drag to look around" : "Turning around the scene");
  }

  /** Whether something moves before something that stands still. */
  get hasSubject(): boolean {
    const totals = this.player.manifest?.totals;
    return totals !== undefined && totals.splatsDynamic > 0 && totals.splatsStatic > 0;
  }

  toggleSubjectOnly(): void {
    const { player } = this;
    if (!this.hasSubject) return;
    player.subjectOnly = !player.subjectOnly;
    if (player.scene) showSwitch(player.scene, player.disposed);
    this.#done(player.subjectOnly ? "Only what moves" : "Everything");
  }

  resetCamera(): void {
    this.player.camera.reset();
    this.surroundings.notify("Back to the camera");
  }

  /** Copy a link that opens on the same picture. */
  async copyLink(): Promise<void> {
    const { link, bookmarks, notify, fail } = this.surroundings;
    if (!link) return;
    const { player } = this;
    const own = player.manifest?.capturedSpace?.subjectOnly ?? false;
    const address = link({
      subjectOnly: player.subjectOnly === own ? null : player.subjectOnly,
      time: player.currentTime,
      paused: player.paused,
      camera: player.camera.name,
      view: player.camera.view,
      loopRange: player.loopRange,
      bookmarks: bookmarks.times,
    });
    try {
      await navigator.clipboard.writeText(address);
      notify("Link copied");
    } catch {
      fail(`This browser does not allow copying. The link: ${address}`); // pages over http without a certificate
    }
  }

  /** Save the picture as a file. */
  async savePicture(): Promise<void> {
    const { notify, fail } = this.surroundings;
    try {
      notify(`Saved ${await savePicture(this.player)}`);
    } catch (error) {
      fail(`The picture could not be saved: ${error instanceof Error ? error.message : error}`);
    }
  }

  #done(text: string): void {
    this.surroundings.notify(text);
    this.surroundings.changed();
  }
}

/**
 * "studio 0m01.20s.png": a file name from a scene's title and a time, seconds; without characters that file systems
 * refuse.
 */
export function pictureName(title: string, time: number): string {
  const hundredths = Math.round(100 * Math.max(0, time));
  const seconds = ((hundredths % 6000) / 100).toFixed(2).padStart(5, "0");
  const name = title.replace(/[^\p{L}\p{N}._-]+/gu, " ").trim() || "scene";
  return `${name} ${Math.floor(hundredths / 6000)}m${seconds}s.png`;
}

/**
 * Save the player's picture in the best quality by the browser; returns the name of the file.
 *
 * @throws Error if nothing has been drawn yet.
 */
export async function savePicture(player: HgsPlayer): Promise<string> {
  const name = pictureName(player.manifest?.title ?? "", player.currentTime - player.start);
  const address = URL.createObjectURL(await player.screenshot());
  element("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000); // the browser may read it late
  return name;
}
