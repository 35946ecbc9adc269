/** The scale of a chart: figures to places. */

export interface Scale {
  readonly low: number;
  readonly high: number;
  /** Round values in the range, for grid lines. */
  readonly ticks: readonly number[];
}

/** A scale that contains the values and about `count` round ticks. */
export function scaleOf(values: readonly number[], count: number): Scale {
  let low = Number.POSITIVE_INFINITY;
  let high = Number.NEGATIVE_INFINITY;
  for (const value of values) {
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  if (!(low <= high)) return { low: 0, high: 1, ticks: [] };
  if (low === high) {
    const half = Math.abs(low) / 10 || 1;
    low -= half;
    high += half;
  }
  const step = roundStep((high - low) / count);
  const first = Math.floor(low / step);
  const last = Math.ceil(high / step);
  const ticks = Array.from({ length: last - first + 1 }, (_, i) => cleaned((first + i) * step));
  return { low: ticks[0], high: ticks[ticks.length - 1], ticks };
}

/** 1, 2 or 5 times a power of ten, and not less than `least`. */
function roundStep(least: number): number {
  const power = 10 ** Math.floor(Math.log10(least));
  return power * ([1, 2, 5].find((factor) => factor * power >= least * (1 - 1e-9)) ?? 10);
}

/** A value without the last digits that binary fractions leave: 0.3 for 0.30000000000000004. */
const cleaned = (value: number): number => Number(value.toPrecision(12));

/** The points [x, y] as an SVG path in a box of `width` by `height`, with y upwards. */
export function linePath(
  points: readonly (readonly [number, number])[],
  x: { readonly low: number; readonly high: number },
  y: { readonly low: number; readonly high: number },
  width: number,
  height: number,
): string {
  const place = ([a, b]: readonly [number, number]): string => {
    const across = ((a - x.low) / (x.high - x.low || 1)) * width;
    const up = height - ((b - y.low) / (y.high - y.low || 1)) * height;
    return `${across.toFixed(1)} ${up.toFixed(1)}`;
  };
  if (points.length === 1) return `M${place(points[0])}h0`; // a dot, with round ends
  return points.length === 0 ? "" : `M${points.map(place).join("L")}`;
}
