import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { length, normalise, subtract, type Vec3 } from "../../src/camera/vector";
import {
  cameraAt,
  type KeyFrame,
  keyAt,
  keysOf,
  numbersOf,
  pathDocument,
  withKey,
  withoutKey,
} from "../../src/keyframes/camera_path";

interface Vectors {
  readonly path: { readonly keys: { time: number; position: Vec3; target: Vec3; vertical_fov: number }[] };
  readonly cameras: { time: number; position: Vec3; forward: Vec3; vertical_fov: number }[];
}

const VECTORS: Vectors = JSON.parse(
  readFileSync(new URL("../../../tests/vectors/camera_path.json", import.meta.url), "utf8"),
);
const KEYS: readonly KeyFrame[] = VECTORS.path.keys.map(({ vertical_fov, ...key }) => ({
  ...key,
  verticalFov: vertical_fov,
}));

describe("a camera path", () => {
  it.each(VECTORS.cameras)("is that of hgs render at $time s", ({ time, position, forward, vertical_fov }) => {
    const found = cameraAt(KEYS, time);
    expect(length(subtract(found.position, position))).toBeLessThan(1e-12);
    const ahead = normalise(subtract(found.target, found.position));
    expect(length(subtract(ahead, forward))).toBeLessThan(1e-12);
    expect(found.verticalFov).toBeCloseTo(vertical_fov, 10);
  });

  it("stands still with one key frame", () => {
    expect(cameraAt(KEYS.slice(0, 1), 2).position).toEqual(KEYS[0].position);
  });

  it("has key frames in order of time, one at a time", () => {
    const later = { ...KEYS[0], time: 2 };
    expect(withKey(KEYS, later).map(({ time }) => time)).toEqual([0.2, 0.9, 1.1, 2, 3]);
    const moved = withKey(KEYS, { ...later, time: 0.905 });
    expect(moved.map(({ time }) => time)).toEqual([0.2, 0.905, 1.1, 3]);
    expect(keyAt(KEYS, 1.104)).toBe(KEYS[2]);
    expect(keyAt(KEYS, 1.2)).toBeUndefined();
    expect(withoutKey(KEYS, 3)).toEqual(KEYS.slice(0, 3));
  });

  it("comes back from the numbers of an address", () => {
    expect(keysOf(numbersOf(KEYS))).toEqual(KEYS);
    expect(numbersOf([{ ...KEYS[0], time: 0.123456789 }])[0]).toBe(0.1234568);
    expect(keysOf([])).toEqual([]);
  });

  it("is saved as the vectors' file", () => {
    expect(JSON.parse(pathDocument(KEYS))).toEqual(VECTORS.path);
  });
});
