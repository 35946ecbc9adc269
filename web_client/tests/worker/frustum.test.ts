import fc from "fast-check";
import { describe, expect, it } from "vitest";
import { type Intrinsics, type Pose, poseAt } from "../../src/camera/pinhole";
import { add, apply, cross, dot, fromRows, normalise, scale, type Vec3 } from "../../src/camera/vector";
import { StaticBlocks } from "../../src/worker/blocks";
import { frustumOf, mayShow, reachOf } from "../../src/worker/frustum";
import { staticChunk } from "../scene";

interface Splat {
  readonly mean: Vec3;
  readonly logScales: Vec3;
  /** Unit vectors along its axes. */
  readonly axes: readonly [Vec3, Vec3, Vec3];
  readonly opacity: number;
}

/** Half the sides of a splat's box on the screen and its middle, as docs/numerics.md (Projection) states them. */
function boxOf({ mean, logScales, axes, opacity }: Splat, { rotation, translation }: Pose, camera: Intrinsics) {
  const [x, y, z] = add(apply(rotation, mean), translation);
  if (z < camera.near || 255 * opacity < 1) return null;
  const { fx, fy, cx, cy, width, height } = camera;
  const beyond = 0.3;
  const tanX = width / (2 * fx);
  const tanY = height / (2 * fy);
  const u = Math.min((width - cx) / fx + beyond * tanX, Math.max(-cx / fx - beyond * tanX, x / z));
  const v = Math.min((height - cy) / fy + beyond * tanY, Math.max(-cy / fy - beyond * tanY, y / z));
  let xx = 0.3;
  let yy = 0.3;
  axes.forEach((axis, i) => {
    const a = scale(apply(rotation, axis), Math.exp(logScales[i]));
    xx += dot([fx / z, 0, (-fx * u) / z], a) ** 2;
    yy += dot([0, fy / z, (-fy * v) / z], a) ** 2;
  });
  const power = 2 * Math.log(255 * opacity);
  return {
    x: (fx * x) / z + cx,
    y: (fy * y) / z + cy,
    halfWidth: Math.sqrt(power * xx),
    halfHeight: Math.sqrt(power * yy),
  };
}

/** Whether any of the picture's pixels may show the splat. */
function touches(splat: Splat, pose: Pose, camera: Intrinsics): boolean {
  const box = boxOf(splat, pose, camera);
  if (!box) return false;
  const [dx, dy] = [Math.max(-box.x, box.x - camera.width, 0), Math.max(-box.y, box.y - camera.height, 0)];
  return dx <= box.halfWidth && dy <= box.halfHeight;
}

const number = (min: number, max: number) => fc.double({ min, max, noNaN: true });
const vector = (size: number) => fc.tuple(number(-size, size), number(-size, size), number(-size, size));
const frame = fc.tuple(vector(1), vector(1)).map(([a, b]): [Vec3, Vec3, Vec3] => {
  const z = normalise(a, [0, 0, 1]);
  const x = normalise(cross(b, z), normalise(cross(Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], z)));
  return [x, cross(z, x), z];
});
const camera = fc
  .record({ width: number(1, 2000), height: number(1, 2000), fx: number(20, 3000), fy: number(20, 3000) })
  .chain((size) =>
    fc
      .record({ cx: number(-0.3, 1.3), cy: number(-0.3, 1.3), near: number(1e-6, 1) })
      .map(({ cx, cy, near }) => ({ ...size, cx: cx * size.width, cy: cy * size.height, near })),
  );
const pose = fc.tuple(vector(5), frame).map(([eye, axes]) => poseAt(eye, fromRows(...axes)));

/** A camera and splats that lie about the border of its picture, of a tenth of a pixel to a thousand pixels there. */
const about = (splats: number) =>
  fc.tuple(pose, camera).chain(([p, c]) => {
    const size = number(-2, 7);
    const one = fc
      .record({
        at: fc.tuple(number(-0.5, 1.5), number(-0.5, 1.5)),
        z: number(c.near, 6),
        sizes: fc.tuple(size, size, size),
        axes: frame,
        opacity: number(0.003, 1),
      })
      .map(({ at, z, sizes, axes, opacity }): Splat => {
        const [u, v] = [(at[0] * c.width - c.cx) / c.fx, (at[1] * c.height - c.cy) / c.fy];
        const [x, y, depth] = add([u * z, v * z, z], scale(p.translation, -1));
        const r = p.rotation;
        const mean = [0, 1, 2]
          .map((i) => r[i] * x + r[3 + i] * y + r[6 + i] * depth)
          .map(Math.fround) as unknown as Vec3;
        const logScales = sizes.map((log) => Math.fround(log + Math.log(z / c.fx))) as unknown as Vec3;
        return { mean, logScales, axes, opacity };
      });
    return fc.tuple(fc.constant(p), fc.constant(c), fc.array(one, { minLength: splats, maxLength: splats }));
  });

const reach = ({ opacity, logScales }: Splat) => reachOf(opacity, ...logScales);

describe("frustumOf", () => {
  it("keeps every splat that a pixel of the picture may show, without any slack", () => {
    let [touching, kept, all] = [0, 0, 0];
    fc.assert(
      fc.property(about(20), ([p, c, splats]) => {
        for (const s of splats) {
          const keeps = mayShow(frustumOf(p, c, 0), ...s.mean, reach(s));
          all++;
          if (keeps) kept++;
          if (!touches(s, p, c)) continue;
          touching++;
          expect(keeps).toBe(true);
        }
      }),
      { numRuns: 500 },
    );
    expect(touching).toBeGreaterThan(0.05 * all);
    expect(kept).toBeLessThan(0.9 * all);
  });

  it("leaves out most of what lies around the picture", () => {
    const c = { width: 640, height: 480, fx: 500, fy: 500, cx: 320, cy: 240, near: 0.1 };
    const frustum = frustumOf(poseAt([0, 0, 0], [1, 0, 0, 0, 1, 0, 0, 0, 1]), c);
    const kept = [-40, -32, -20, 0, 20, 32, 40].map((degrees) => {
      const angle = (degrees * Math.PI) / 180;
      return mayShow(frustum, 3 * Math.sin(angle), 0, 3 * Math.cos(angle), 0.01);
    });
    expect(kept).toEqual([false, true, true, true, true, true, false].map((keep, i) => keep && i > 0 && i < 6));
    expect(mayShow(frustum, 0, 0, -3, 0.01)).toBe(false);
  });
});

describe("StaticBlocks", () => {
  it("keeps a block if one of its splats may show", () => {
    fc.assert(
      fc.property(about(3), ([p, c, splats]) => {
        const chunk = staticChunk(splats.flatMap(({ mean }) => [...mean]));
        splats.forEach(({ opacity, logScales }, i) => {
          chunk.opacities[i] = opacity;
          chunk.logScales.set(logScales, 3 * i);
        });
        const r = p.rotation;
        const depth = { kind: "planar", x: r[6], y: r[7], z: r[8], offset: p.translation[2], near: c.near } as const;
        const keeps = new StaticBlocks(0, chunk).mayShow(0, depth, frustumOf(p, c));
        if (splats.some((s) => touches(s, p, c))) expect(keeps).toBe(true);
      }),
      { numRuns: 500 },
    );
  });

  it("leaves out a block of which nothing can show: beside the picture, behind it, or too faint", () => {
    const chunk = staticChunk([0, 0, 5, 0.1, 0, 5]);
    const c = { width: 100, height: 100, fx: 100, fy: 100, cx: 50, cy: 50, near: 0.1 };
    const shows = (x: number, z: number) => {
      const depth = { kind: "planar", x: 0, y: 0, z: 1, offset: z, near: 0.1 } as const;
      const frustum = frustumOf({ rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [x, 0, z] }, c);
      return new StaticBlocks(0, chunk).mayShow(0, depth, frustum);
    };
    expect([shows(0, 0), shows(9, 0), shows(-9, 0), shows(0, -6)]).toEqual([true, false, false, false]);
    chunk.opacities.fill(0.003);
    expect(shows(0, 0)).toBe(false);
  });
});
