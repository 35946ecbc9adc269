/** Clouds of splats in Morton order, as chunks hold them, and a camera that turns. */

import { type Intrinsics, type Pose, poseAt } from "../src/camera/pinhole";
import type { Manifest, StaticChunk } from "../src/codec/types";
import { placeStatics, type StaticPlacement } from "../src/renderer/layout";
import type { PlanarDepth } from "../src/worker/depth";
import { random } from "../tests/random";

const BITS = 10;

function morton(x: number, y: number, z: number): number {
  let code = 0;
  for (let bit = BITS - 1; bit >= 0; bit--) {
    code = code * 8 + (((z >> bit) & 1) * 4 + ((y >> bit) & 1) * 2 + ((x >> bit) & 1));
  }
  return code;
}

/** A cube of four units about the origin; splats of a centimetre. */
export function cloud(count: number): { splats: StaticChunk; manifest: Manifest; placement: StaticPlacement } {
  const next = random(7);
  const cells = Float64Array.from({ length: count }, () => {
    const cell = () => Math.floor(next() * 2 ** BITS);
    return morton(cell(), cell(), cell());
  }).sort();
  const means = new Float32Array(3 * count);
  cells.forEach((code, i) => {
    for (let k = 0; k < 3; k++) {
      let cell = 0;
      for (let bit = 0; bit < BITS; bit++) cell += (Math.floor(code / 2 ** (3 * bit + k)) % 2) * 2 ** bit;
      means[3 * i + k] = 4 * ((cell + next()) / 2 ** BITS) - 2;
    }
  });
  const box = { min: [-2, -2, -2], max: [2, 2, 2] } as const;
  const splats: StaticChunk = {
    kind: "static",
    count,
    timeRange: [0, 0],
    box,
    bounds: { position: 0, blur: 0, shape: 0, opacity: 0, rgb: 0 },
    means,
    quats: new Float32Array(4 * count),
    logScales: new Float32Array(3 * count).fill(Math.log(0.01)),
    opacities: new Float32Array(count).fill(0.5),
    rgb: new Float32Array(3 * count),
  };
  const manifest = { static: [{ id: "cloud", bytes: 1, splats: count, box }], slices: [], segments: [] };
  const checked = manifest as unknown as Manifest;
  return { splats, manifest: checked, placement: placeStatics(checked) };
}

/** A camera that has turned by `angle` about the vertical, and looks at the cube's middle from a distance, or from it. */
export function turning(angle: number, distance: number): { pose: Pose; camera: Intrinsics; depth: PlanarDepth } {
  const [sin, cos] = [Math.sin(angle), Math.cos(angle)];
  const pose = poseAt([-sin * distance, 0, -cos * distance], [cos, 0, -sin, 0, 1, 0, sin, 0, cos]);
  const camera = { width: 1280, height: 720, fx: 900, fy: 900, cx: 640, cy: 360, near: 0.1 };
  const depth = { kind: "planar", x: sin, y: 0, z: cos, offset: pose.translation[2], near: camera.near } as const;
  return { pose, camera, depth };
}
