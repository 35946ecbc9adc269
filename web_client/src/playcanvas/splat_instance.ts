/** The splats' representative among PlayCanvas' mesh instances: nothing to see, drawn after opaque ones. */

import {
  BLEND_PREMULTIPLIED,
  BoundingBox,
  CULLFACE_NONE,
  type GraphicsDevice,
  type GraphNode,
  Mesh,
  MeshInstance,
  PRIMITIVE_TRIANGLES,
  SEMANTIC_POSITION,
  SHADER_FORWARD,
  ShaderMaterial,
  Vec3,
} from "playcanvas";
import type { Manifest } from "../codec/types";
import { roomOf } from "../host/splat_room";

/** The material by which PlayCanvas itself sets blending, depth, culling and masks for splats, and keeps track of them. */
function splatMaterial(): ShaderMaterial {
  const material = new ShaderMaterial({
    uniqueName: "HgsScene",
    attributes: { place: SEMANTIC_POSITION },
    vertexGLSL: "attribute vec3 place; void main() { gl_Position = vec4(place, 1.0); }",
    fragmentGLSL: "void main() { gl_FragColor = vec4(0.0); }",
  });
  material.blendType = BLEND_PREMULTIPLIED;
  material.depthWrite = false;
  material.cull = CULLFACE_NONE;
  material.update();
  return material;
}

/** A triangle without an area. */
function nothing(device: GraphicsDevice): Mesh {
  const mesh = new Mesh(device);
  mesh.setPositions(new Float32Array(9));
  mesh.update(PRIMITIVE_TRIANGLES);
  return mesh;
}

export class SplatInstance extends MeshInstance {
  readonly #draw: () => void;

  /**
   * Create the instance.
   *
   * @param draw called at the splats' turn, with the state of the material set.
   */
  constructor(device: GraphicsDevice, node: GraphNode, draw: () => void) {
    super(nothing(device), splatMaterial(), node);
    this.#draw = draw;
    this.cull = false; // each splat is, and the playhead may move on unnoticed
    this.pick = false;
    this.shaderPassMask = 1 << SHADER_FORWARD; // the others draw something other than a picture, such as depths
  }

  override setParameters(device: GraphicsDevice): void {
    super.setParameters(device);
    this.#draw();
  }

  /** Set the bounds of the splats' centres at all times: the order among transparent objects is that of their middle. */
  bound(manifest: Manifest): void {
    const { min, max } = roomOf(manifest);
    const room = new BoundingBox();
    room.setMinMax(new Vec3(...min), new Vec3(...max));
    this.setCustomAabb(room);
  }

  override destroy(): void {
    const { material } = this;
    super.destroy();
    material?.destroy();
  }
}
