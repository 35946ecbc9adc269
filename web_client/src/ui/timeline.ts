/** The timeline: playhead, loaded stretches, repeated stretch, and bookmarks. */

import { element, setAttribute } from "../dom/element";
import { formatTime } from "../dom/format";
import type { HgsPlayer } from "../player/hgs_player";
import type { Bookmarks } from "./bookmarks";

/** A CSS gradient that shows the ranges on a bar from `start` to `end`. */
export function bufferedGradient(ranges: readonly (readonly [number, number])[], start: number, end: number): string {
  const percent = (time: number) => `${((100 * (time - start)) / (end - start)).toFixed(2)}%`;
  const stops = ranges.flatMap(([from, to]) => {
    const [a, b] = [percent(from), percent(to)];
    return [`transparent ${a}`, `var(--buffered) ${a}`, `var(--buffered) ${b}`, `transparent ${b}`];
  });
  return stops.length > 0 ? `linear-gradient(to right, ${stops.join(", ")})` : "none";
}

export class Timeline {
  readonly #seek = element("input", {
    type: "range",
    class: "seek",
    "aria-label": "Position",
    min: 0,
    max: 1,
    step: "any",
  });
  readonly node = element("div", { class: "timeline" }, this.#seek);
  #resume = false;
  #dragging = false;
  #chunks = -1; // number of chunks received or lost at the last update of the buffer
  #marked = false; // true if there are marks, or were

  /** Create the timeline of the present scene. `step` moves the playhead by frames. */
  constructor(
    readonly player: HgsPlayer,
    readonly bookmarks: Bookmarks,
    step: (frames: number) => void,
  ) {
    this.#seek.min = String(player.start);
    this.#seek.max = String(player.end);
    this.#seek.addEventListener("input", () => this.#scrub());
    this.#seek.addEventListener("change", () => this.#drop());
    this.#seek.addEventListener("keydown", (event) => {
      const frames = { ArrowDown: -1, ArrowUp: 1 }[event.key];
      if (frames === undefined || event.shiftKey) return;
      event.preventDefault();
      step(frames);
    });
    const point = async (event: PointerEvent): Promise<void> => {
      const { showTimes } = await import("./time_bubble"); // not needed on touch screens
      showTimes(this, this.#seek, event);
    };
    // biome-ignore lint/suspicious/noConsole: a detail that no visitor requested
    this.#seek.addEventListener("pointerenter", (event) => point(event).catch(console.warn), { once: true });
  }

  /** Whether the knob is held. */
  readonly dragged = (): boolean => this.#dragging;

  /** Whether the scene plays on after the drag. */
  get resumes(): boolean {
    return this.#resume;
  }

  /** Show the player's state; called at every frame of the player. */
  update(): void {
    const { player } = this;
    const { statistics, currentTime, start, end } = player;
    if (!statistics) return;
    if (this.#seek.max !== String(end)) {
      this.#seek.max = String(end); // a grown scene changes the places on the bar
      this.#chunks = -1;
      this.mark();
    }
    if (!this.#dragging) this.#seek.value = String(currentTime);
    setAttribute(this.#seek, "aria-valuetext", formatTime(currentTime - start));
    this.#seek.style.setProperty("--played", ((currentTime - start) / (end - start)).toFixed(4));
    const { chunks, lostChunks } = statistics;
    if (chunks + lostChunks === this.#chunks) return;
    this.#chunks = chunks + lostChunks;
    this.#seek.style.setProperty("--ranges", bufferedGradient(player.buffered, start, end));
  }

  /** Show the bookmarks and the repeated stretch. */
  mark(): void {
    this.#marked ||= this.player.loopRange !== null || this.bookmarks.times.length > 0;
    // biome-ignore lint/suspicious/noConsole: the scene works without
    if (this.#marked) import("./timeline_marks").then(({ showMarks }) => showMarks(this), console.warn); // rarely used
  }

  /** Pause the scene while the knob is dragged, and play on afterwards. */
  #scrub(): void {
    if (!this.#dragging) {
      this.#dragging = true;
      this.#resume = !this.player.paused;
      this.player.pause();
    }
    this.player.currentTime = Number(this.#seek.value);
  }

  #drop(): void {
    this.#dragging = false;
    if (this.#resume) this.player.play();
    this.#resume = false;
  }
}
