import { expect, it } from "vitest";
import type { Vec3 } from "../../src/camera/vector";
import { backdropColours, mixed, plain } from "../../src/xr/backdrop_colours";
import type { Panorama } from "../../src/xr/panorama";

const UP: Vec3 = [0, 0, 1];
const GREY: Vec3 = [0.2, 0.2, 0.2];

/** Straight up, all round and straight down, each covered by `alpha` with a colour. */
const panorama = (above: Vec3, level: Vec3, below: Vec3, alpha = [1, 1, 1]): Panorama => {
  const glimpse = (direction: Vec3, [r, g, b]: Vec3, a: number) => ({
    direction,
    size: 1,
    light: [r * a, g * a, b * a] as const,
    alpha: a,
  });
  const [right, left, ahead, behind] = [
    [1, 0, 0],
    [-1, 0, 0],
    [0, 1, 0],
    [0, -1, 0],
  ] as Vec3[];
  const sides = [right, left, ahead, behind].map((way) => glimpse(way, level, alpha[1]));
  return [glimpse(UP, above, alpha[0]), ...sides, glimpse([0, 0, -1], below, alpha[2])];
};

const close = (a: Vec3, b: Vec3) => {
  for (const i of [0, 1, 2]) expect(a[i]).toBeCloseTo(b[i], 6);
};

it("are what the scene shows above, about and below the horizon, dimmed", () => {
  const { above, level, below } = backdropColours(panorama([1, 0, 0], [0, 1, 0], [0, 0, 1]), UP, GREY);
  close(above, [0.3, 0, 0]);
  close(level, [0, 0.45, 0]);
  close(below, [0, 0, 0.28]);
});

it("do not become darker where the scene covers half", () => {
  const { level } = backdropColours(panorama([1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0.5, 1]), UP, GREY);
  close(level, [0, 0.45, 0]);
});

it("are those of the whole scene where nobody filmed", () => {
  const { above } = backdropColours(panorama([1, 1, 1], [0, 1, 0], [0, 1, 0], [0, 1, 1]), UP, GREY);
  close(above, [0, 0.3, 0]);
});

it("are the background's where there is no scene", () => {
  expect(backdropColours(panorama(UP, UP, UP, [0, 0, 0]), UP, GREY)).toEqual(plain(GREY));
});

it("come softly", () => {
  const { above, below } = mixed(plain([0, 0, 0]), { above: [1, 0, 0], level: UP, below: [0, 1, 0] }, 0.25);
  expect([above, below]).toEqual([
    [0.25, 0, 0],
    [0, 0.25, 0],
  ]);
});
