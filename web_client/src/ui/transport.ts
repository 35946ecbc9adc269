/** The bar below the picture: play, seek with buffered ranges, time, rate, loop. */

import type { Manifest } from "../codec/types";
import type { HgsPlayer } from "../player/hgs_player";
import { element, icon, setAttribute, setText } from "./element";
import { formatTime } from "./format";
import { LOOP, PAUSE, PLAY, REPLAY } from "./icons";

const RATES = [0.25, 0.5, 1, 2];

/** A CSS gradient that shows the ranges on a bar from `start` to `end`. */
export function bufferedGradient(ranges: readonly (readonly [number, number])[], start: number, end: number): string {
  const percent = (time: number) => `${((100 * (time - start)) / (end - start)).toFixed(2)}%`;
  const stops = ranges.flatMap(([from, to]) => {
    const [a, b] = [percent(from), percent(to)];
    return [`transparent ${a}`, `var(--buffered) ${a}`, `var(--buffered) ${b}`, `transparent ${b}`];
  });
  return stops.length > 0 ? `linear-gradient(to right, ${stops.join(", ")})` : "none";
}

type Button = "play" | "pause" | "replay";
const ICONS: Readonly<Record<Button, string>> = { play: PLAY, pause: PAUSE, replay: REPLAY };
const LABELS: Readonly<Record<Button, string>> = { play: "Play", pause: "Pause", replay: "Play again" };

export class Transport {
  readonly node: HTMLElement;
  readonly #play = element("button", { type: "button", class: "round", onclick: () => this.toggle() });
  readonly #seek = element("input", {
    type: "range",
    class: "seek",
    "aria-label": "Position",
    min: 0,
    max: 1,
    step: "any",
  });
  readonly #time = element("span", { class: "time" });
  readonly #rate = element("select", { class: "rate", "aria-label": "Speed", title: "Speed" });
  readonly #loop = element(
    "button",
    { type: "button", class: "round small", title: "Loop (L)", "aria-label": "Loop" },
    icon(LOOP),
  );
  readonly #frame: number; // seconds
  #resume = false;
  #dragging = false;
  #shown: Button | null = null;
  #chunks = -1; // that had come, or were lost, at the last look at the buffer

  constructor(
    readonly player: HgsPlayer,
    manifest: Manifest,
  ) {
    for (const rate of RATES) {
      this.#rate.append(element("option", { value: rate, selected: rate === player.playbackRate }, `${rate}×`));
    }
    this.#seek.min = String(manifest.start);
    this.#seek.max = String(manifest.end);
    this.#seek.addEventListener("input", () => this.#scrub());
    this.#seek.addEventListener("change", () => this.#drop());
    this.#seek.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1, ArrowDown: -1, ArrowUp: 1 }[event.key];
      if (step === undefined) return;
      event.preventDefault();
      this.step(step);
    });
    this.#rate.addEventListener("change", () => {
      player.playbackRate = Number(this.#rate.value);
    });
    this.#loop.addEventListener("click", () => this.toggleLoop());
    this.node = element("div", { class: "transport" }, this.#play, this.#seek, this.#time, this.#rate, this.#loop);
    this.#frame = 1 / manifest.frameRate;
    this.node.hidden = manifest.end <= manifest.start; // nothing moves in a still scene
  }

  toggle(): void {
    if (this.node.hidden) return;
    if (this.player.paused) this.player.play();
    else this.player.pause();
  }

  toggleLoop(): void {
    this.player.loop = !this.player.loop;
    this.update();
  }

  /** Stand still, so many frames later. */
  step(frames: number): void {
    this.player.pause();
    this.player.currentTime += frames * this.#frame;
  }

  /** Show the player's state; called at every frame of the player. */
  update(): void {
    const { player } = this;
    const { statistics, currentTime, start, end } = player;
    if (!statistics || this.node.hidden) return;
    this.#showButton(!player.paused || this.#resume ? "pause" : player.ended ? "replay" : "play");
    if (!this.#dragging) this.#seek.value = String(currentTime);
    const position = formatTime(currentTime - start);
    setText(this.#time, `${position} / ${formatTime(player.duration)}`);
    setAttribute(this.#seek, "aria-valuetext", position);
    setAttribute(this.#loop, "aria-pressed", String(player.loop));
    const share = (currentTime - start) / player.duration;
    this.#seek.style.setProperty("--played", `${(100 * share).toFixed(2)}%`);
    const { chunks, lostChunks } = statistics;
    if (chunks + lostChunks === this.#chunks) return;
    this.#chunks = chunks + lostChunks;
    this.#seek.style.setProperty("--ranges", bufferedGradient(player.buffered, start, end));
  }

  #showButton(what: Button): void {
    if (this.#shown === what) return;
    this.#shown = what;
    this.#play.replaceChildren(icon(ICONS[what]));
    this.#play.setAttribute("aria-label", LABELS[what]);
    this.#play.title = `${LABELS[what]} (Space)`;
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
