/** Strokes of a brush and boxes that a hand draws over the picture; other buttons and the wheel stay the camera's. */

import { boxArea, type Point, strokeArea } from "./areas";
import type { Hand } from "./clean_panel";
import type { Area } from "./seen_splats";

export interface StrokeEvents {
  hand(): Hand;
  /** Radius of the brush, CSS pixels. */
  radius(): number;
  begun(): void;
  drawn(area: Area): void;
}

/** Shortest way between two points of a stroke, CSS pixels. */
const STEP = 3;

export class HandStrokes {
  readonly node = svg("svg", { class: "clean-drawing", "aria-hidden": "true" });
  readonly #line = svg("polyline", { class: "clean-stroke" });
  readonly #box = svg("rect", { class: "clean-box" });
  readonly #tip = svg("circle", { class: "clean-tip" });
  #points: [Point, ...Point[]] | null = null; // null without a stroke
  #pointer = -1;

  /**
   * Listen to the picture.
   *
   * @param root root element of the player.
   */
  constructor(
    readonly root: HTMLElement,
    readonly events: StrokeEvents,
  ) {
    this.node.append(this.#line, this.#box, this.#tip);
    const stage = root.querySelector<HTMLElement>(".stage");
    const ahead = { capture: true }; // ahead of the camera's gestures
    stage?.addEventListener("pointerdown", (event) => this.#down(event), ahead);
    stage?.addEventListener("pointermove", (event) => this.#move(event), ahead);
    stage?.addEventListener("pointerup", (event) => this.#up(event, true), ahead);
    stage?.addEventListener("pointercancel", (event) => this.#up(event, false), ahead);
    stage?.addEventListener("pointerleave", () => this.#draw(null), ahead);
  }

  #at({ clientX, clientY }: PointerEvent): Point {
    const { left, top } = this.root.getBoundingClientRect();
    return [clientX - left, clientY - top];
  }

  #down(event: PointerEvent): void {
    if (this.events.hand() === "look") return;
    if (this.#points) {
      event.stopImmediatePropagation(); // a second finger
      return;
    }
    if (event.button !== 0 || event.shiftKey) return; // moves the camera
    event.stopImmediatePropagation();
    event.preventDefault();
    (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId);
    this.#pointer = event.pointerId;
    this.#points = [this.#at(event)];
    this.events.begun();
    this.#draw(this.#points[0]);
  }

  #move(event: PointerEvent): void {
    if (this.events.hand() === "look") return;
    const to = this.#at(event);
    if (this.#points) event.stopImmediatePropagation();
    if (this.#points && event.pointerId === this.#pointer) {
      const last = this.#points.at(-1) as Point;
      if (Math.hypot(to[0] - last[0], to[1] - last[1]) >= STEP) this.#points.push(to);
    }
    this.#draw(to);
  }

  #up(event: PointerEvent, whole: boolean): void {
    const points = this.#points;
    if (!points) return;
    event.stopImmediatePropagation();
    if (event.pointerId !== this.#pointer) return;
    this.#points = null;
    this.#draw(this.#at(event));
    if (!whole) return;
    const area =
      this.events.hand() === "box" ? boxArea(points[0], this.#at(event)) : strokeArea(points, this.events.radius());
    this.events.drawn(area);
  }

  #draw(tip: Point | null): void {
    const points = this.#points;
    const boxed = this.events.hand() === "box";
    const radius = this.events.radius();
    this.#line.toggleAttribute("hidden", !points || boxed);
    this.#box.toggleAttribute("hidden", !points || !boxed);
    this.#tip.toggleAttribute("hidden", !tip || boxed || this.events.hand() === "look");
    if (points && boxed && tip) {
      const [x, y, right, bottom] = boxArea(points[0], tip).box;
      set(this.#box, { x, y, width: right - x, height: bottom - y });
    } else if (points) {
      set(this.#line, { points: [...points, points.at(-1)].join(" ") }); // a single point is a dot
      this.#line.style.strokeWidth = `${2 * radius}px`;
    }
    if (tip) set(this.#tip, { cx: tip[0], cy: tip[1], r: radius });
  }
}

function svg<K extends keyof SVGElementTagNameMap>(tag: K, attributes: Record<string, string> = {}) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

function set(node: SVGElement, attributes: Record<string, string | number>): void {
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, String(value));
}
