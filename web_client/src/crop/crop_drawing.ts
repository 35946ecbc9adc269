/** The drawing of a box over the picture: its edges, hidden ones dashed, the lengths of its sides, and handles. */

import { add, row, scale, type Vec3 } from "../camera/vector";
import { type CropBox, corners, EDGES, FACES, faces, seenEndOn } from "./crop_box";
import { type Handle, placeOf, TURN_REACH } from "./crop_drag";
import { type CropView, type Pixel, seenAt, seenLine } from "./crop_view";

const RING_STEPS = 64;
const GRIP = 22; // CSS pixels around a handle's middle: enough for a finger
const DOT = 7;

const HANDLES: readonly { readonly handle: Handle; readonly name: string }[] = [
  ...FACES.map((face) => ({ handle: face, name: "face" })),
  { handle: "middle", name: "middle" },
  { handle: "turn", name: "turn" },
];

export class CropDrawing {
  readonly node = svg("svg", { class: "crop-drawing", "aria-hidden": "true" });
  readonly #dim = svg("path", { class: "crop-dim", "fill-rule": "evenodd" });
  readonly #behind = svg("path", { class: "crop-behind" });
  readonly #halo = svg("path", { class: "crop-halo" });
  readonly #edges = svg("path", { class: "crop-edges" });
  readonly #floor = svg("path", { class: "crop-floor" });
  readonly #ring = svg("path", { class: "crop-ring" });
  readonly #lengths = [0, 1, 2].map(() => svg("text", { class: "crop-length" }));
  readonly #handles = HANDLES.map(({ handle, name }) => {
    const group = svg("g", { class: `crop-handle crop-${name}` });
    group.append(svg("circle", { class: "crop-grip", r: GRIP }), svg("circle", { class: "crop-dot", r: DOT }));
    return { handle, group };
  });

  /**
   * Create the drawing.
   *
   * @param grab is called when a handle is pressed.
   */
  constructor(grab: (handle: Handle, event: PointerEvent, group: SVGElement) => void, signal: AbortSignal) {
    const groups = this.#handles.map(({ group }) => group);
    this.node.append(
      this.#dim,
      this.#floor,
      this.#behind,
      this.#ring,
      this.#halo,
      this.#edges,
      ...this.#lengths,
      ...groups,
    );
    for (const { handle, group } of this.#handles) {
      group.addEventListener("pointerdown", (event) => grab(handle, event, group), { signal });
    }
  }

  /** Draw a box in a view; `inverse`: the inside is removed. */
  show(box: CropBox, inverse: boolean, view: CropView): void {
    const { width, height } = view.camera;
    const places = corners(box);
    const front: string[] = [];
    const behind: string[] = [];
    for (const edge of EDGES) {
      const [from, to] = edge.ends.map((i) => places[i] as Vec3) as [Vec3, Vec3];
      const line = seenLine(from, to, view);
      if (line) (edge.faces.some((face) => faces(box, face, view.eye)) ? front : behind).push(pathOf(line));
    }
    this.#edges.setAttribute("d", front.join(""));
    this.#halo.setAttribute("d", front.join(""));
    this.#behind.setAttribute("d", behind.join(""));
    const seen = places.map((place) => seenAt(place, view));
    const outline = seen.every((place) => place !== null) ? `${pathOf(hull(seen as Pixel[]))}Z` : "";
    const all = `M0 0H${width}V${height}H0Z`;
    // From inside of the box nothing can be dimmed: its outline surrounds the eye.
    this.#dim.setAttribute("d", outline && (inverse ? outline : all + outline));
    const floor = [2, 3, 7, 6].map((corner) => seen[corner]);
    this.#floor.setAttribute("d", floor.every((place) => place) ? `${pathOf(floor as Pixel[])}Z` : "");
    this.#showRing(box, view);
    this.#showLengths(box, view);
    for (const { handle, group } of this.#handles) {
      const end = typeof handle === "object" && seenEndOn(box, handle, view.eye);
      const place = end ? null : seenAt(placeOf(handle, box), view);
      group.toggleAttribute("hidden", place === null);
      if (place) group.setAttribute("transform", `translate(${place[0].toFixed(1)} ${place[1].toFixed(1)})`);
      if (typeof handle === "object") group.classList.toggle("crop-far", !faces(box, handle, view.eye));
    }
  }

  /** The path of the turn's handle: a circle on the floor. */
  #showRing(box: CropBox, view: CropView): void {
    const floor = add(box.center, scale(row(box.axes, 1), box.size[1] / 2));
    const radius = TURN_REACH * box.size[2];
    const at = (step: number) => {
      const angle = (2 * Math.PI * step) / RING_STEPS;
      const aside = add(scale(row(box.axes, 0), Math.sin(angle)), scale(row(box.axes, 2), Math.cos(angle)));
      return add(floor, scale(aside, radius));
    };
    const lines = Array.from({ length: RING_STEPS }, (_, step) => seenLine(at(step), at(step + 1), view));
    this.#ring.setAttribute("d", lines.map((line) => (line ? pathOf(line) : "")).join(""));
  }

  /** Show the length of each axis at its lowest edge in the picture that is not hidden. */
  #showLengths(box: CropBox, view: CropView): void {
    const places = corners(box);
    this.#lengths.forEach((text, axis) => {
      let lowest: Pixel | null = null;
      for (const { ends, faces: meeting } of EDGES) {
        if (meeting.some((face) => face.axis === axis)) continue;
        if (meeting.every((face) => !faces(box, face, view.eye))) continue;
        const middle = scale(add(places[ends[0]] as Vec3, places[ends[1]] as Vec3), 0.5);
        const place = seenAt(middle, view);
        if (place && (lowest === null || place[1] > lowest[1])) lowest = place;
      }
      text.toggleAttribute("hidden", lowest === null);
      if (!lowest) return;
      const [away, out] = [seenAt(box.center, view) ?? lowest, 18];
      const [dx, dy] = [lowest[0] - away[0], lowest[1] - away[1]];
      const far = Math.hypot(dx, dy) || 1;
      text.setAttribute("x", (lowest[0] + (dx / far) * out).toFixed(1));
      text.setAttribute("y", (lowest[1] + (dy / far) * out).toFixed(1));
      text.textContent = Number((box.size[axis] as number).toPrecision(3)).toString();
    });
  }
}

/** The convex hull of places, in order (Andrew's monotone chain). */
export function hull(places: readonly Pixel[]): Pixel[] {
  const sorted = [...places].sort(([a, b], [c, d]) => a - c || b - d);
  const half = (points: readonly Pixel[]) => {
    const chain: Pixel[] = [];
    for (const point of points) {
      while (chain.length > 1 && turn(chain.at(-2) as Pixel, chain.at(-1) as Pixel, point) <= 0) chain.pop();
      chain.push(point);
    }
    return chain.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

const turn = (a: Pixel, b: Pixel, c: Pixel): number => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);

const pathOf = (points: readonly Pixel[]): string =>
  points.map(([x, y], i) => `${i ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");

function svg(tag: string, attributes: Readonly<Record<string, string | number>>): SVGElement {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  return made;
}
