import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { magnification, rigOf } from "../../src/camera/magnification";
import { poseOf } from "../../src/camera/pinhole";
import type { ManifestCamera } from "../../src/codec/types";

type Listed = Omit<ManifestCamera, "worldToCamera"> & { readonly world_to_camera: number[][] };
interface Vectors {
  readonly rig: readonly Listed[];
  readonly views: readonly { readonly camera: Listed; readonly magnification: readonly number[] }[];
}

const VECTORS: Vectors = JSON.parse(
  readFileSync(new URL("../../../tests/vectors/magnification.json", import.meta.url), "utf8"),
);
const read = ({ world_to_camera, ...camera }: Listed): ManifestCamera => ({
  ...camera,
  worldToCamera: world_to_camera,
});

describe("magnification", () => {
  it.each(VECTORS.views)("is that of the vectors: $camera.name", ({ camera, magnification: expected }) => {
    const rig = rigOf({ photographed: true, cameras: VECTORS.rig.map(read) });
    const found = magnification(rig, poseOf(camera.world_to_camera), camera);
    expected.forEach((value, i) => {
      expect(found[i]).toBeCloseTo(value, 9);
    });
  });

  it("is below 1 in the view of every camera of the rig, for all depths", () => {
    const rig = rigOf({ photographed: true, cameras: VECTORS.rig.map(read) });
    for (const camera of VECTORS.rig) {
      const [a, b, c, d] = magnification(rig, poseOf(camera.world_to_camera), camera);
      for (const z of [0.01, 1, 1000]) expect((a * z + b * z + c * z + d) / z).toBeLessThan(1);
    }
  });

  it("is nothing without a rig", () => {
    const camera = read(VECTORS.rig[0]);
    expect(
      magnification(rigOf({ photographed: false, cameras: [camera] }), poseOf(camera.worldToCamera), camera),
    ).toEqual([0, 0, 0, 0]);
  });
});
