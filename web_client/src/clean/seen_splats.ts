/** The splats that an area of a picture shows: those with a centre inside that others do not hide. */

import type { Intrinsics } from "../camera/pinhole";
import { DYNAMIC_TEXELS, FIFTH_TEXELS, LOW_PASS, STATIC_TEXELS } from "../renderer/layout";
import type { Shot } from "../renderer/shot";
import type { DecodedSplats } from "../worker/messages";
import { DELETED, HIDDEN } from "./splat_marks";

/** Decoded splats of a chunk, with their number. */
export type ChunkSplats = Pick<DecodedSplats, "id" | "kind" | "texels" | "fifth"> & { readonly count: number };

/** An area of the picture, pixels; `box` is left, top, right, bottom. */
export interface Area {
  readonly box: readonly [number, number, number, number];
  contains(x: number, y: number): boolean;
}

/** Share of light from a splat that passes all before it; below, the splat counts as hidden. */
const SEEN = 0.1;
/** Most cells along a side of an area. */
const CELLS = 256;
const VISIBLE = 1 / 255;
const OPAQUE = 0.99;

/** Numbers of a projected splat: depth, place, inverse covariance (3), opacity, reach across and down. */
const NUMBERS = 9;

/**
 * The seen splats, by chunk: their places in it, ascending.
 *
 * @param shot defines pose and time; `camera` its picture in the area's pixels.
 * @param marks returns the marks of a chunk: hidden and deleted splats neither count nor hide others.
 * @param through finds hidden splats, too.
 */
export function seenSplats(
  chunks: readonly ChunkSplats[],
  shot: Shot,
  camera: Intrinsics,
  area: Area,
  marks: (id: string) => Uint8Array | undefined,
  through: boolean,
): Map<string, number[]> {
  const [left, top, right, bottom] = area.box;
  const cell = Math.max(1, Math.max(right - left, bottom - top) / CELLS);
  const total = chunks.reduce((sum, { count }) => sum + count, 0);
  const numbers = new Float32Array(NUMBERS * total);
  const owners = new Uint32Array(total);
  const places = new Uint32Array(total);
  let found = 0;
  chunks.forEach((chunk, owner) => {
    const skipped = marks(chunk.id);
    const project = projection(chunk, shot, camera, LOW_PASS * cell * cell);
    for (let i = 0; i < chunk.count; i++) {
      if (skipped && skipped[i] & (HIDDEN | DELETED)) continue;
      const at = NUMBERS * found;
      if (!project(i, numbers, at)) continue;
      const [x, y, across, down] = [numbers[at + 1], numbers[at + 2], numbers[at + 7], numbers[at + 8]];
      if (x + across < left || x - across > right || y + down < top || y - down > bottom) continue;
      owners[found] = owner;
      places[found++] = i;
    }
  });
  const order = Uint32Array.from({ length: found }, (_, i) => i);
  order.sort((a, b) => numbers[NUMBERS * a] - numbers[NUMBERS * b]);
  const light = new Light(area.box, cell);
  const hits = new Map<string, number[]>();
  for (const splat of order) {
    const at = NUMBERS * splat;
    const [x, y] = [numbers[at + 1], numbers[at + 2]];
    if (area.contains(x, y) && (through || light.at(x, y) >= SEEN)) {
      const { id } = chunks[owners[splat]];
      const list = hits.get(id);
      if (list) list.push(places[splat]);
      else hits.set(id, [places[splat]]);
    }
    if (!through) light.dim(numbers, at);
  }
  for (const list of hits.values()) list.sort((a, b) => a - b);
  return hits;
}

/** The share of light that passes the splats so far, in the cells of a box. */
class Light {
  readonly #width: number;
  readonly #height: number;
  readonly #cells: Float32Array;

  constructor(
    readonly box: Area["box"],
    readonly cell: number,
  ) {
    this.#width = Math.max(1, Math.ceil((box[2] - box[0]) / cell));
    this.#height = Math.max(1, Math.ceil((box[3] - box[1]) / cell));
    this.#cells = new Float32Array(this.#width * this.#height).fill(1);
  }

  at(x: number, y: number): number {
    const column = Math.min(this.#width - 1, Math.max(0, Math.floor((x - this.box[0]) / this.cell)));
    const line = Math.min(this.#height - 1, Math.max(0, Math.floor((y - this.box[1]) / this.cell)));
    return this.#cells[line * this.#width + column];
  }

  /** Take away the light held back by a projected splat. */
  dim(numbers: Float32Array, from: number): void {
    const [, x, y, a, b, c, opacity, across, down] = numbers.subarray(from, from + NUMBERS);
    const [left, top] = this.box;
    const { cell } = this;
    const first = Math.max(0, Math.floor((x - across - left) / cell));
    const last = Math.min(this.#width - 1, Math.floor((x + across - left) / cell));
    const end = Math.min(this.#height - 1, Math.floor((y + down - top) / cell));
    for (let line = Math.max(0, Math.floor((y - down - top) / cell)); line <= end; line++) {
      const dy = top + (line + 0.5) * cell - y;
      for (let column = first; column <= last; column++) {
        const dx = left + (column + 0.5) * cell - x;
        const alpha = opacity * Math.exp(-0.5 * (a * dx * dx + c * dy * dy) - b * dx * dy);
        if (alpha >= VISIBLE) this.#cells[line * this.#width + column] *= 1 - Math.min(OPAQUE, alpha);
      }
    }
  }
}

/** A function that projects a chunk's splat as splat.vert does, widened by `blur`; false if it is not drawn. */
function projection(
  { kind, texels, fifth }: ChunkSplats,
  { pose, time, still = 1 }: Shot,
  { fx, fy, cx, cy, width, height, near }: Intrinsics,
  blur: number,
): (i: number, numbers: Float32Array, at: number) => boolean {
  const [r, t] = [pose.rotation, pose.translation];
  const [marginX, marginY] = [(0.15 * width) / fx, (0.15 * height) / fy];
  const position = [0, 0, 0];
  const q = [0, 0, 0, 0];
  const p = [0, 0, 0];
  return (i, numbers, at) => {
    let opacity: number;
    let sigma: number; // index of the first deviation
    if (kind === "static") {
      const from = 4 * STATIC_TEXELS * i;
      for (let k = 0; k < 3; k++) position[k] = texels[from + k];
      for (let k = 0; k < 4; k++) q[k] = texels[from + 4 + k];
      opacity = still * texels[from + 3];
      sigma = from + 8;
    } else {
      const from = 4 * DYNAMIC_TEXELS * i;
      const d = time - texels[from + 27];
      opacity = texels[from + 23] * Math.exp(-texels[from + 28] * d * d);
      const more = fifth.length > 0 && texels[from + 29] > 0 ? 4 * FIFTH_TEXELS * i : -1;
      for (let k = 0; k < 3; k++) {
        const high = more < 0 ? 0 : d * (fifth[more + k] + d * fifth[more + 4 + k]);
        const cubic = texels[from + 9 + k] + high;
        position[k] = texels[from + k] + d * (texels[from + 3 + k] + d * (texels[from + 6 + k] + d * cubic));
      }
      for (let k = 0; k < 4; k++) q[k] = texels[from + 12 + k] + d * texels[from + 16 + k];
      sigma = from + 20;
    }
    if (!(opacity >= VISIBLE)) return false;
    for (let k = 0; k < 3; k++) {
      p[k] = r[3 * k] * position[0] + r[3 * k + 1] * position[1] + r[3 * k + 2] * position[2] + t[k];
    }
    if (!(p[2] >= near)) return false;
    const [u, v] = [p[0] / p[2], p[1] / p[2]];
    const slantX = Math.min(Math.max(u, -cx / fx - marginX), (width - cx) / fx + marginX);
    const slantY = Math.min(Math.max(v, -cy / fy - marginY), (height - cy) / fy + marginY);
    const size = Math.hypot(q[0], q[1], q[2], q[3]) || 1;
    const [w, x, y, z] = size < 1e-12 ? [1, 0, 0, 0] : q.map((part) => part / size);
    let [xx, xy, yy] = [0, 0, 0];
    for (let axis = 0; axis < 3; axis++) {
      // A standard deviation along an axis of the splat, in the world, then before the camera, then in pixels.
      const [a, b, c] =
        axis === 0
          ? [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)]
          : axis === 1
            ? [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)]
            : [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)];
      const deep = r[6] * a + r[7] * b + r[8] * c;
      const scale = texels[sigma + axis] / p[2];
      const jx = fx * scale * (r[0] * a + r[1] * b + r[2] * c - slantX * deep);
      const jy = fy * scale * (r[3] * a + r[4] * b + r[5] * c - slantY * deep);
      xx += jx * jx;
      xy += jx * jy;
      yy += jy * jy;
    }
    const sharp = xx * yy - xy * xy;
    xx += blur;
    yy += blur;
    const determinant = xx * yy - xy * xy;
    // A splat thinner than a cell holds back less of its light.
    const thinned = opacity * Math.sqrt(Math.max(0, sharp / determinant));
    const reach = Math.sqrt(Math.max(0, 2 * Math.log(255 * thinned)));
    numbers[at] = p[2];
    numbers[at + 1] = fx * u + cx;
    numbers[at + 2] = fy * v + cy;
    numbers[at + 3] = yy / determinant;
    numbers[at + 4] = -xy / determinant;
    numbers[at + 5] = xx / determinant;
    numbers[at + 6] = thinned;
    numbers[at + 7] = reach * Math.sqrt(xx);
    numbers[at + 8] = reach * Math.sqrt(yy);
    return true;
  };
}
