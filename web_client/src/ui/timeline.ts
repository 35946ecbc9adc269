/** The bar that shows and moves the playhead: what is loaded, the repeated stretch, bookmarks, and the time under the pointer. */

import type { HgsPlayer } from "../player/hgs_player";
import type { Bookmarks } from "./bookmarks";
import { element, setAttribute, setText } from "./element";
import { formatTime } from "./format";

/** Half of the knob's width, CSS pixels: so far from its ends the bar's first and last moment lie. */
const KNOB = 8;

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
  readonly #bubble = element("span", { class: "bubble", "aria-hidden": "true", hidden: true });
  readonly #range = element("span", { class: "loop-range", hidden: true });
  readonly #marks = element("span", { class: "marks" });
  readonly node = element("div", { class: "timeline" }, this.#seek, this.#range, this.#marks, this.#bubble);
  #resume = false;
  #dragging = false;
  #chunks = -1; // that had come, or were lost, at the last look at the buffer
  #shownMarks: readonly number[] = [];

  /** For the scene that the player shows now. `step` goes on by so many frames. */
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
    this.#seek.addEventListener("pointermove", (event) => this.#point(event));
    for (const type of ["pointerleave", "pointercancel"]) {
      this.#seek.addEventListener(type, () => {
        this.#bubble.hidden = true;
      });
    }
  }

  /** Whether the scene would play if it were not dragged. */
  get resumes(): boolean {
    return this.#resume;
  }

  /** Show the player's state; called at every frame of the player. */
  update(): void {
    const { player } = this;
    const { statistics, currentTime, start, end } = player;
    if (!statistics) return;
    if (this.#seek.max !== String(end)) {
      this.#seek.max = String(end); // the scene has grown: what there is of it has another place on the bar
      this.#chunks = -1;
      this.#shownMarks = [];
      this.mark();
    }
    if (!this.#dragging) this.#seek.value = String(currentTime);
    setAttribute(this.#seek, "aria-valuetext", formatTime(currentTime - start));
    this.#setShare(this.#seek, "--played", currentTime);
    const { chunks, lostChunks } = statistics;
    if (chunks + lostChunks === this.#chunks) return;
    this.#chunks = chunks + lostChunks;
    this.#seek.style.setProperty("--ranges", bufferedGradient(player.buffered, start, end));
  }

  /** Show the bookmarks and the repeated stretch. */
  mark(): void {
    const range = this.player.loopRange;
    this.#range.hidden = range === null;
    if (range) {
      this.#setShare(this.#range, "--from", range[0]);
      this.#setShare(this.#range, "--to", range[1]);
    }
    const { times } = this.bookmarks;
    if (times === this.#shownMarks) return;
    this.#shownMarks = times;
    this.#marks.replaceChildren(
      ...times.map((time) => {
        const mark = element("span", { class: "mark" });
        this.#setShare(mark, "--at", time);
        return mark;
      }),
    );
  }

  #setShare(target: HTMLElement, property: string, time: number): void {
    const { start, duration } = this.player;
    const share = ((time - start) / duration).toFixed(4);
    if (target.style.getPropertyValue(property) !== share) target.style.setProperty(property, share);
  }

  /** Say which moment is under the pointer. */
  #point({ clientX, pointerType }: PointerEvent): void {
    if (pointerType === "touch" && !this.#dragging) return;
    const { left, width } = this.#seek.getBoundingClientRect();
    const share = Math.max(0, Math.min(1, (clientX - left - KNOB) / (width - 2 * KNOB)));
    setText(this.#bubble, formatTime(share * this.player.duration));
    this.#bubble.style.setProperty("--at", share.toFixed(4));
    this.#bubble.hidden = false;
  }

  /** While the knob is dragged the scene stands where it is, and goes on afterwards. */
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
