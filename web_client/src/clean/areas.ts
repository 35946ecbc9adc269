/** Areas of a picture that hands draw: boxes, and strokes of a round brush. */

import type { Area } from "./seen_splats";

export type Point = readonly [number, number];

/** The box between two corners. */
export function boxArea([a, b]: Point, [c, d]: Point): Area {
  const box = [Math.min(a, c), Math.min(b, d), Math.max(a, c), Math.max(b, d)] as const;
  return { box, contains: (x, y) => x >= box[0] && x <= box[2] && y >= box[1] && y <= box[3] };
}

/** All places within `radius` of a line through points; a circle about a single point. */
export function strokeArea(points: readonly [Point, ...Point[]], radius: number): Area {
  const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => y)];
  const box = [
    Math.min(...xs) - radius,
    Math.min(...ys) - radius,
    Math.max(...xs) + radius,
    Math.max(...ys) + radius,
  ] as const;
  const contains = (x: number, y: number): boolean => {
    if (x < box[0] || x > box[2] || y < box[1] || y > box[3]) return false;
    return points.some((point, i) => squareDistance([x, y], points[Math.max(0, i - 1)], point) <= radius * radius);
  };
  return { box, contains };
}

/** Square of the distance of a point from the line between two others. */
function squareDistance([x, y]: Point, [ax, ay]: Point, [bx, by]: Point): number {
  const [dx, dy] = [bx - ax, by - ay];
  const length = dx * dx + dy * dy;
  const along = length > 0 ? Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / length)) : 0;
  return (x - ax - along * dx) ** 2 + (y - ay - along * dy) ** 2;
}
