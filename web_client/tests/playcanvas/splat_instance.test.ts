import { GraphNode, NullGraphicsDevice, SHADER_FORWARD } from "playcanvas";
import { afterAll, beforeAll, describe, expect, it, vi } from "vitest";
import { SplatInstance } from "../../src/playcanvas/splat_instance";
import { entry, manifest, slice } from "../scene";

let device: NullGraphicsDevice;

beforeAll(() => {
  const canvas = { width: 8, height: 8, addEventListener: () => {}, removeEventListener: () => {} };
  device = new NullGraphicsDevice(canvas as unknown as HTMLCanvasElement);
});

afterAll(() => device.destroy());

function instance(draw = () => {}): [SplatInstance, GraphNode] {
  const node = new GraphNode("splats");
  return [new SplatInstance(device, node, draw), node];
}

describe("the mesh instance that stands for splats", () => {
  it("draws at its turn, in passes that draw pictures", () => {
    const draw = vi.fn();
    const [made] = instance(draw);
    expect(draw).not.toHaveBeenCalled();
    made.setParameters(device);
    expect(draw).toHaveBeenCalledTimes(1);
    expect(made.shaderPassMask).toBe(1 << SHADER_FORWARD);
    expect([made.transparent, made.cull]).toEqual([true, false]);
  });

  it("has the room of the splats, still and moving, where its node is", () => {
    const [made, node] = instance();
    node.setPosition(10, 0, 0);
    const still = { ...entry("a"), box: { min: [-1, -2, 0], max: [1, 1, 1] } } as const;
    const moving = {
      ...slice(0, 1, []),
      chunks: [{ ...entry("b"), box: { min: [0, 0, 0], max: [5, 1, 9] } }],
    } as const;
    made.bound(manifest({ static: [still], slices: [moving] }));
    const { aabb } = made;
    expect([aabb.getMin(), aabb.getMax()].map(({ x, y, z }) => [x, y, z])).toEqual([
      [9, -2, 0],
      [15, 1, 9],
    ]);
  });

  it("takes its mesh and its material with it", () => {
    const [made] = instance();
    const destroyed = vi.spyOn(made.material!, "destroy");
    const before = device.buffers.size;
    made.destroy();
    expect(destroyed).toHaveBeenCalledTimes(1);
    expect(device.buffers.size).toBe(before - 1);
  });
});
