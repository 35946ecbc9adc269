import { readFileSync } from "node:fs";
import fc from "fast-check";
import { describe, expect, it } from "vitest";
import {
  eyeAt,
  isInside,
  limited,
  nearestInside,
  type OrbitPose,
  orbitPoseOf,
  type Space,
  springBack,
  unlimited,
} from "../../src/camera/captured_space";
import { readSeenLimits } from "../../src/camera/seen_limits";
import { normalise, scale, subtract, type Vec3 } from "../../src/camera/vector";
import type { CapturedSpace } from "../../src/codec/types";

interface Vector {
  readonly center: Vec3;
  readonly up: Vec3;
  readonly captured_space: Omit<CapturedSpace, "azimuth"> & { readonly azimuth?: number };
  readonly places: readonly (OrbitPose & { readonly eye: Vec3; readonly inside: boolean })[];
}

const VECTORS: Vector[] = JSON.parse(
  readFileSync(new URL("../../../tests/vectors/captured_space.json", import.meta.url), "utf8"),
);
const ARC: CapturedSpace = { front: [1, 0, 0], azimuth: 0.7, elevation: [-0.25, 0.3], distance: [1, 2.5] };
const DOME: CapturedSpace = { ...ARC, azimuth: null };
/** Narrower at the sides, and to one point at the right end. */
const SEEN = {
  azimuth: [-0.6, 0.5],
  elevation: [
    [-0.1, 0.1],
    [-0.25, 0.3],
    [0.05, 0.05],
  ],
  distance: [
    [
      [1, 1.5],
      [1, 2.5],
    ],
    [
      [1.2, 2],
      [1, 2.5],
    ],
    [
      [1.5, 1.5],
      [1.4, 1.8],
    ],
  ],
};
const narrowed = (space: CapturedSpace, seen: unknown): Space => ({
  ...space,
  limits: readSeenLimits({ ...space, seen }),
});
const NARROW_ARC = narrowed(ARC, SEEN);
const NARROW_DOME = narrowed(DOME, { elevation: SEEN.elevation, distance: SEEN.distance });
const NUMBERS = ["azimuth", "elevation", "distance"] as const;

const anyPose = fc.record({
  azimuth: fc.double({ min: -20, max: 20, noNaN: true }),
  elevation: fc.double({ min: -Math.PI / 2, max: Math.PI / 2, noNaN: true }),
  distance: fc.double({ min: 1e-3, max: 1e3, noNaN: true }),
});
const anySpace = fc
  .record({
    azimuth: fc.option(fc.double({ min: 0.01, max: 3, noNaN: true })),
    low: fc.double({ min: -1.5, max: 1.5, noNaN: true }),
    height: fc.double({ min: 0, max: 1, noNaN: true }),
    nearest: fc.double({ min: 0.01, max: 100, noNaN: true }),
    ratio: fc.double({ min: 1, max: 10, noNaN: true }),
  })
  .map(
    ({ azimuth, low, height, nearest, ratio }): CapturedSpace => ({
      front: [1, 0, 0],
      azimuth,
      elevation: [low, low + height],
      distance: [nearest, nearest * ratio],
    }),
  );

function expectClose(found: OrbitPose, expected: OrbitPose, digits = 9): void {
  for (const name of NUMBERS) expect(found[name]).toBeCloseTo(expected[name], digits);
}

describe.each(VECTORS)("the shared vectors around $center", ({ center, up, captured_space, places }) => {
  const box: CapturedSpace = { ...captured_space, azimuth: captured_space.azimuth ?? null };
  const space = narrowed(box, box.seen);
  const frame = { center, up, front: space.front };

  it("are read as the places they are", () => {
    for (const place of places) expectClose(orbitPoseOf(place.eye, frame), place);
  });

  it("lie inside or outside as they say", () => {
    for (const place of places) expect(isInside(orbitPoseOf(place.eye, frame), space)).toBe(place.inside);
  });

  it("are where their numbers lead to", () => {
    for (const place of places) {
      const eye = eyeAt(place, frame);
      for (const axis of [0, 1, 2] as const) expect(eye[axis]).toBeCloseTo(place.eye[axis], 9);
    }
  });
});

it("eyes and poses are each other's inverse in any frame", () => {
  const coordinate = fc.double({ min: -5, max: 5, noNaN: true });
  const vector = fc.tuple(coordinate, coordinate, coordinate);
  fc.assert(
    fc.property(vector, vector, vector, vector, (center, eye, upward, ahead) => {
      const up = normalise(upward);
      const along = up[0] * ahead[0] + up[1] * ahead[1] + up[2] * ahead[2];
      const across = subtract(ahead, scale(up, along));
      fc.pre(Math.hypot(...upward) > 0.1 && Math.hypot(...across) > 0.1);
      const frame = { center, up, front: normalise(across) };
      const back = eyeAt(orbitPoseOf(eye, frame), frame);
      for (const axis of [0, 1, 2] as const) expect(back[axis]).toBeCloseTo(eye[axis], 9);
    }),
  );
});

describe("limited", () => {
  it("changes nothing inside", () => {
    fc.assert(
      fc.property(anyPose, anySpace, (pose, space) => {
        const inside = nearestInside(pose, space);
        expect(isInside(inside, space)).toBe(true);
        expect(limited(inside, space)).toEqual(inside);
      }),
    );
  });

  it("follows a drag beyond the border ever less, and never farther than the band gives", () => {
    const shown = [0.7, 0.8, 0.9, 1.1, 1.5, 3, 100].map((azimuth) =>
      limited({ azimuth, elevation: 0, distance: 2 }, ARC),
    );
    const steps = shown.slice(1).map(({ azimuth }, i) => azimuth - shown[i].azimuth);
    for (const step of steps) expect(step).toBeGreaterThan(0);
    expect(steps[0]).toBeLessThan(0.1);
    expect(shown.at(-1)?.azimuth).toBeLessThan(0.9);
    expect(shown.at(-1)?.azimuth).toBeGreaterThan(0.89);
  });

  it("gives way as much on either side", () => {
    const beyond = { azimuth: 1, elevation: 0, distance: 2 };
    const other = { ...beyond, azimuth: -1 };
    expect(limited(other, ARC).azimuth).toBe(-limited(beyond, ARC).azimuth);
    expect(limited({ ...beyond, distance: 5 }, DOME).distance / 2.5).toBeCloseTo(
      1 / limited({ ...beyond, distance: 0.5 }, DOME).distance,
    );
  });

  it("keeps the order of poses, so that a drag back moves the picture back", () => {
    fc.assert(
      fc.property(anyPose, anyPose, anySpace, (a, b, space) => {
        const [first, second] = [limited(a, space), limited(b, space)];
        for (const name of NUMBERS) {
          if (a[name] <= b[name])
            expect(first[name]).toBeLessThanOrEqual(second[name] + 1e-9 * Math.max(1, Math.abs(second[name])));
        }
      }),
    );
  });

  it("lets the camera go round where cameras stand all round", () => {
    expect(limited({ azimuth: 9, elevation: 0, distance: 2 }, DOME).azimuth).toBe(9);
  });

  it("knows no limits where the space is not known", () => {
    fc.assert(
      fc.property(anyPose, (pose) => {
        expect(isInside(pose, null)).toBe(true);
        for (const map of [limited, unlimited, nearestInside]) expect(map(pose, null)).toEqual(pose);
        expect(springBack(pose, null, 1)).toEqual(pose);
      }),
    );
  });
});

describe("unlimited", () => {
  it("is the inverse of limited, so that a drag that begins beyond the border does not jump", () => {
    const near = fc.record({
      azimuth: fc.double({ min: -3, max: 3, noNaN: true }),
      elevation: fc.double({ min: -1.5, max: 1.5, noNaN: true }),
      distance: fc.double({ min: 0.2, max: 10, noNaN: true }),
    });
    fc.assert(
      fc.property(near, (asked) => {
        expectClose(unlimited(limited(asked, ARC), ARC), asked, 6);
      }),
    );
  });

  it("is finite at the very end of the band and past it", () => {
    for (const azimuth of [0.9, 2]) {
      expect(Number.isFinite(unlimited({ azimuth, elevation: 0, distance: 2 }, ARC).azimuth)).toBe(true);
    }
  });
});

describe("springBack", () => {
  it("comes nearer to the border all the time and rests exactly on it", () => {
    let pose = limited({ azimuth: 2, elevation: -1, distance: 9 }, ARC);
    const rest = nearestInside(pose, ARC);
    expect(isInside(pose, ARC)).toBe(false);
    for (let frame = 0; frame < 120; frame++) {
      const next = springBack(pose, ARC, 1 / 60);
      for (const name of NUMBERS) {
        const [before, after] = [Math.abs(pose[name] - rest[name]), Math.abs(next[name] - rest[name])];
        if (before > 0) expect(after).toBeLessThan(before);
      }
      pose = next;
    }
    expect(pose).toEqual(rest);
    expect(isInside(pose, ARC)).toBe(true);
  });

  it("does not depend on the rate of frames", () => {
    const start = limited({ azimuth: 2, elevation: 0, distance: 2 }, ARC);
    let many = start;
    for (let frame = 0; frame < 12; frame++) many = springBack(many, ARC, 1 / 120);
    expectClose(many, springBack(start, ARC, 0.1));
  });

  it("leaves alone what is inside", () => {
    const pose = { azimuth: 0.1, elevation: 0.1, distance: 2 };
    expect(springBack(pose, ARC, 1)).toEqual(pose);
  });
});

describe.each([
  ["an arc", NARROW_ARC],
  ["a dome", NARROW_DOME],
])("in %s with narrower limits", (_, space) => {
  const near = fc.record({
    azimuth: fc.double({ min: -7, max: 7, noNaN: true }),
    elevation: fc.double({ min: -1.5, max: 1.5, noNaN: true }),
    distance: fc.double({ min: 0.2, max: 10, noNaN: true }),
  });

  it("the place of rest is inside, and stays where it is", () => {
    fc.assert(
      fc.property(near, (pose) => {
        const rest = nearestInside(pose, space);
        expect(isInside(rest, space)).toBe(true);
        expect(limited(rest, space)).toEqual(rest);
      }),
    );
  });

  it("unlimited is the inverse of limited", () => {
    fc.assert(
      fc.property(near, (asked) => {
        const shown = limited(asked, space);
        expectClose(limited(unlimited(shown, space), space), shown, 6);
        if (Math.abs(asked.azimuth) < 3) expectClose(unlimited(shown, space), asked, 5);
      }),
    );
  });

  it("a small step asked for is a small step shown, along any border", () => {
    fc.assert(
      fc.property(near, (pose) => {
        const [here, there] = [pose, { ...pose, azimuth: pose.azimuth + 1e-6 }].map((one) => limited(one, space));
        for (const name of NUMBERS) expect(Math.abs(here[name] - there[name])).toBeLessThan(1e-4);
      }),
    );
  });

  it("a camera that is let go comes to rest exactly inside", () => {
    fc.assert(
      fc.property(near, (pose) => {
        let shown = limited(pose, space);
        for (let frame = 0; frame < 200; frame++) shown = springBack(shown, space, 1 / 60);
        expect(isInside(shown, space)).toBe(true);
        expectClose(shown, nearestInside(limited(pose, space), space));
      }),
    );
  });
});
