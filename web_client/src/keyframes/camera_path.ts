/**
 * Camera paths: key frames on the scene's clock, and smooth motion through them, as `hgs render --path` draws it
 * (docs/interchange.md, "Films").
 */

import type { Vec3 } from "../camera/vector";

export interface KeyFrame {
  /** Seconds of the scene's clock. */
  readonly time: number;
  readonly position: Vec3;
  /** The point in the middle of the picture. */
  readonly target: Vec3;
  /** Degrees. */
  readonly verticalFov: number;
}

/** Numbers of a key frame in an address. */
export const KEY_NUMBERS = 8;

/** Distance of key frames below which they count as one, seconds. */
const APART = 0.01;

const near = (a: number, b: number): boolean => Math.abs(a - b) < APART;

/** The key frames in order of time with another one, which replaces one at its time. */
export function withKey(keys: readonly KeyFrame[], key: KeyFrame): readonly KeyFrame[] {
  return [...withoutKey(keys, key.time), key].sort((a, b) => a.time - b.time);
}

/** The key frames without the one at a time. */
export const withoutKey = (keys: readonly KeyFrame[], time: number): readonly KeyFrame[] =>
  keys.filter((key) => !near(key.time, time));

/** The key frame at a time, if there is one. */
export const keyAt = (keys: readonly KeyFrame[], time: number): KeyFrame | undefined =>
  keys.find((key) => near(key.time, time));

/** The numbers of key frames for an address: seven digits, far below a pixel. */
export const numbersOf = (keys: readonly KeyFrame[]): readonly number[] =>
  keys.flatMap(({ time, position, target, verticalFov }) =>
    [time, ...position, ...target, verticalFov].map((value) => Number(value.toPrecision(7))),
  );

/** The key frames of an address's numbers. */
export function keysOf(numbers: readonly number[]): readonly KeyFrame[] {
  return Array.from({ length: numbers.length / KEY_NUMBERS }, (_, i) => {
    const [time, ...rest] = numbers.slice(i * KEY_NUMBERS, (i + 1) * KEY_NUMBERS);
    return {
      time,
      position: rest.slice(0, 3) as unknown as Vec3,
      target: rest.slice(3, 6) as unknown as Vec3,
      verticalFov: rest[6],
    };
  });
}

/** The file of `hgs render --path`. */
export function pathDocument(keys: readonly KeyFrame[]): string {
  const plain = keys.map(({ time, position, target, verticalFov }) => ({
    time,
    position,
    target,
    vertical_fov: verticalFov,
  }));
  return `${JSON.stringify({ format: "hgs-camera-path", version: 1, keys: plain }, null, 1)}\n`;
}

/**
 * The camera at a time: cubic Hermite curves of position, target and the logarithm of the focal length. Before the first
 * key frame and after the last one it stands still.
 */
export function cameraAt(keys: readonly KeyFrame[], time: number): KeyFrame {
  const rows = keys.map((key) => [...key.position, ...key.target, -Math.log(Math.tan(radians(key.verticalFov) / 2))]);
  const found = hermite(
    keys.map((key) => key.time),
    rows,
    time,
  );
  return {
    time,
    position: found.slice(0, 3) as unknown as Vec3,
    target: found.slice(3, 6) as unknown as Vec3,
    verticalFov: (2 * Math.atan(Math.exp(-found[6])) * 180) / Math.PI,
  };
}

const radians = (degrees: number): number => (degrees * Math.PI) / 180;

/** The curve through rows of values at rising times. */
function hermite(times: readonly number[], rows: readonly (readonly number[])[], at: number): readonly number[] {
  const last = times.length - 1;
  if (last === 0 || at <= times[0]) return rows[0];
  if (at >= times[last]) return rows[last];
  const left = times.findIndex((time) => time > at) - 1;
  const step = times[left + 1] - times[left];
  const s = (at - times[left]) / step;
  return rows[left].map((begin, i) => {
    const end = rows[left + 1][i];
    const [first, second] = [left, left + 1].map((place) => slope(times, rows, place, i) * step);
    return (
      begin * (1 + 2 * s) * (1 - s) ** 2 +
      first * s * (1 - s) ** 2 +
      end * s * s * (3 - 2 * s) +
      second * s * s * (s - 1)
    );
  });
}

/** The derivative at a key frame: of the parabola through three of them, of the line through two at the ends. */
function slope(times: readonly number[], rows: readonly (readonly number[])[], place: number, i: number): number {
  const between = (a: number) => (rows[a + 1][i] - rows[a][i]) / (times[a + 1] - times[a]);
  if (place === 0) return between(0);
  if (place === times.length - 1) return between(place - 1);
  const before = times[place] - times[place - 1];
  const after = times[place + 1] - times[place];
  return (between(place - 1) * after + between(place) * before) / (before + after);
}
