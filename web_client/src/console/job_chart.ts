/** The curve of a training: a figure over its progress. */

import { element, setText } from "../dom/element";
import { linePath, scaleOf } from "./chart_scale";
import type { JobCourse } from "./job_course";
import { figureName, figureText } from "./job_words";

const STAGE = "train"; // stage with figures worth a curve
const LEAST_HEIGHT = 220; // pixels
const MARGIN = { left: 46, right: 12, top: 12, bottom: 26 };
const SVG = "http://www.w3.org/2000/svg";

export class JobChart {
  readonly #choices = element("div", { class: "chart-choices", role: "group", "aria-label": "Figure" });
  readonly #readout = element("p", { class: "hint" });
  readonly #svg = document.createElementNS(SVG, "svg");
  readonly node = element(
    "section",
    { class: "chart", "aria-label": "Training curve", hidden: true },
    element("div", { class: "chart-head" }, this.#choices, this.#readout),
    this.#svg,
  );
  #figure = "";
  #points: readonly [number, number][] = [];
  #course: JobCourse | null = null;

  constructor() {
    this.#svg.setAttribute("role", "img");
    new ResizeObserver(() => this.#draw()).observe(this.node);
    this.#svg.addEventListener("pointermove", (event) => this.#read(event));
    this.#svg.addEventListener("pointerleave", () => this.#readLast());
  }

  show(course: JobCourse): void {
    this.#course = course;
    const figures = course.figures(STAGE);
    this.node.hidden = figures.length === 0;
    if (figures.length === 0) return;
    if (!figures.includes(this.#figure)) this.#figure = figures[0];
    if (this.#choices.dataset.figures !== figures.join()) {
      this.#choices.dataset.figures = figures.join();
      this.#choices.replaceChildren(...figures.map((name) => this.#choice(name)));
    }
    const points = course.curve(STAGE, this.#figure);
    const last = points.at(-1);
    const before = this.#points.at(-1);
    const same = points.length === this.#points.length && last?.[0] === before?.[0] && last?.[1] === before?.[1];
    this.#points = points;
    if (!same) this.#draw();
  }

  #choice(name: string): HTMLElement {
    const button = element(
      "button",
      { type: "button", class: "chip", "aria-pressed": String(name === this.#figure) },
      figureName(name),
    );
    button.addEventListener("click", () => {
      this.#figure = name;
      for (const other of this.#choices.children) other.setAttribute("aria-pressed", String(other === button));
      this.#points = this.#course?.curve(STAGE, name) ?? [];
      this.#draw();
    });
    return button;
  }

  #draw(): void {
    const width = this.#svg.clientWidth || this.node.clientWidth;
    if (width === 0 || this.#points.length === 0) return;
    const tall = Math.max(this.#svg.clientHeight, LEAST_HEIGHT);
    const inner = { width: width - MARGIN.left - MARGIN.right, height: tall - MARGIN.top - MARGIN.bottom };
    const last = this.#points[this.#points.length - 1];
    const x = { low: 0, high: last[0] };
    const y = scaleOf(
      this.#points.map((point) => point[1]),
      4,
    );
    const height = (value: number): number => MARGIN.top + inner.height * (1 - (value - y.low) / (y.high - y.low));
    this.#svg.setAttribute("viewBox", `0 0 ${width} ${tall}`);
    const first = this.#points[0];
    const words = `${figureName(this.#figure)} from ${figureText(this.#figure, first[1])} to ${figureText(this.#figure, last[1])}`;
    this.#svg.setAttribute("aria-label", `${words} after ${last[0].toLocaleString("en")} iterations`);
    const line = shape("path", {
      class: "curve",
      d: linePath(this.#points, x, y, inner.width, inner.height),
      transform: `translate(${MARGIN.left} ${MARGIN.top})`,
    });
    this.#svg.replaceChildren(
      ...y.ticks.flatMap((tick) => [
        shape("line", { class: "grid", x1: MARGIN.left, x2: width - MARGIN.right, y1: height(tick), y2: height(tick) }),
        label(String(tick), MARGIN.left - 8, height(tick) + 4, "end"),
      ]),
      label("0", MARGIN.left, tall - 6, "start"),
      label(`${last[0].toLocaleString("en")} iterations`, width - MARGIN.right, tall - 6, "end"),
      line,
    );
    this.#readLast();
  }

  #readLast(): void {
    const last = this.#points.at(-1);
    if (last) setText(this.#readout, `Now ${figureText(this.#figure, last[1])}`);
  }

  /** Show the value at the pointer. */
  #read(event: PointerEvent): void {
    const box = this.#svg.getBoundingClientRect();
    const last = this.#points.at(-1);
    if (!last || box.width === 0) return;
    const share = (event.clientX - box.left - MARGIN.left) / (box.width - MARGIN.left - MARGIN.right);
    const wanted = Math.min(Math.max(share, 0), 1) * last[0];
    const [done, value] = this.#points.reduce((a, b) => (Math.abs(b[0] - wanted) < Math.abs(a[0] - wanted) ? b : a));
    setText(this.#readout, `${figureText(this.#figure, value)} at ${done.toLocaleString("en")}`);
  }
}

function shape(name: string, attributes: Readonly<Record<string, string | number>>): SVGElement {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
  return made;
}

function label(text: string, x: number, y: number, anchor: string): SVGElement {
  const made = shape("text", { x, y, "text-anchor": anchor });
  made.textContent = text;
  return made;
}
