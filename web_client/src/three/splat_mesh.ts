/** What stands for the splats in three.js' list of things to draw: a mesh without a triangle, drawn after opaque ones. */

import {
  AddEquation,
  Box3,
  BufferGeometry,
  type Camera,
  CustomBlending,
  DoubleSide,
  Float32BufferAttribute,
  GLSL3,
  LessEqualDepth,
  Mesh,
  OneFactor,
  OneMinusSrcAlphaFactor,
  RawShaderMaterial,
  Sphere,
  Vector3,
  type WebGLRenderer,
} from "three";
import type { Box, Manifest } from "../codec/types";

/**
 * By this material three.js itself sets blending, depth, culling and masks as splats need them, and knows that it has. It is
 * drawn among transparent things: after all opaque ones, so that their depth is there.
 */
function splatMaterial(): RawShaderMaterial {
  return new RawShaderMaterial({
    name: "HgsScene",
    glslVersion: GLSL3,
    vertexShader: "in vec3 position; void main() { gl_Position = vec4(position, 1.0); }",
    fragmentShader: "precision lowp float; out vec4 result; void main() { result = vec4(0.0); }",
    transparent: true,
    blending: CustomBlending,
    blendEquation: AddEquation,
    blendSrc: OneFactor,
    blendDst: OneMinusSrcAlphaFactor,
    depthTest: true,
    depthFunc: LessEqualDepth,
    depthWrite: false,
    side: DoubleSide,
    forceSinglePass: true,
  });
}

export class SplatMesh extends Mesh<BufferGeometry, RawShaderMaterial> {
  /** @param draw called when it is the splats' turn, with the state of the material set. */
  constructor(draw: (renderer: WebGLRenderer, camera: Camera) => void) {
    super(new BufferGeometry().setAttribute("position", new Float32BufferAttribute([], 3)), splatMaterial());
    this.frustumCulled = false; // each splat is, and the playhead moves on behind one's back too
    this.geometry.boundingBox = new Box3();
    this.geometry.boundingSphere = new Sphere();
    this.onAfterRender = (renderer, _scene, camera, _geometry, material) => {
      // With another material in its place, the host draws something else than a picture, such as depths.
      if (material === this.material) draw(renderer, camera);
    };
  }

  /** No ray meets it: it has no surface. */
  override raycast(): void {}

  /** Take the room that the splats' centres are ever in, for whoever asks three.js for it. */
  bound(manifest: Manifest): void {
    const chunks = [...manifest.static, ...manifest.slices.flatMap((slice) => slice.chunks)];
    const box = new Box3();
    for (const chunk of chunks) box.union(box3(chunk.box));
    this.geometry.boundingBox = box;
    this.geometry.boundingSphere = box.getBoundingSphere(new Sphere());
  }

  override dispose(): void {
    super.dispose();
    this.geometry.dispose();
    this.material.dispose();
  }
}

const box3 = ({ min, max }: Box): Box3 => new Box3(new Vector3(...min), new Vector3(...max));
