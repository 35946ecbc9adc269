import { Box3, MeshBasicMaterial, PerspectiveCamera, Raycaster, Scene, type WebGLRenderer } from "three";
import { describe, expect, it, vi } from "vitest";
import { SplatMesh } from "../../src/three/splat_mesh";
import { entry, manifest, slice } from "../scene";

const RENDERER = {} as WebGLRenderer;
const CAMERA = new PerspectiveCamera();

describe("the mesh that stands for splats", () => {
  it("draws when its own material is drawn, and not when another takes its place", () => {
    const draw = vi.fn();
    const mesh = new SplatMesh(draw);
    const drawnWith = (material: typeof mesh.material) =>
      mesh.onAfterRender(RENDERER, new Scene(), CAMERA, mesh.geometry, material, null as never);
    drawnWith(new MeshBasicMaterial() as never);
    expect(draw).not.toHaveBeenCalled();
    drawnWith(mesh.material);
    expect(draw.mock.calls).toEqual([[RENDERER, CAMERA]]);
  });

  it("tells three.js the room of the splats, still and moving", () => {
    const mesh = new SplatMesh(() => {});
    const still = { ...entry("a"), box: { min: [-1, -2, 0], max: [1, 1, 1] } } as const;
    const moving = {
      ...slice(0, 1, []),
      chunks: [{ ...entry("b"), box: { min: [0, 0, 0], max: [5, 1, 9] } }],
    } as const;
    mesh.bound(manifest({ static: [still], slices: [moving] }));
    const { min, max } = new Box3().setFromObject(mesh);
    expect([min.toArray(), max.toArray()]).toEqual([
      [-1, -2, 0],
      [5, 1, 9],
    ]);
  });

  it("is met by no ray", () => {
    const mesh = new SplatMesh(() => {});
    mesh.bound(manifest({ static: [entry("a")] }));
    expect(new Raycaster().intersectObject(mesh)).toEqual([]);
  });
});
