/** The splats' representative in three.js' list of objects: a mesh without triangles, drawn after opaque ones. */

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
  type WebGLRenderer,
} from "three";
import type { Manifest } from "../codec/types";
import { splatBox } from "./splat_box";

/**
 * The material by which three.js itself sets blending, depth, culling and masks for splats, and keeps track of them. It
 * is drawn among transparent objects: after all opaque ones, so their depth is there.
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
  /**
   * Create the mesh.
   *
   * @param draw called at the splats' turn, with the state of the material set.
   */
  constructor(draw: (renderer: WebGLRenderer, camera: Camera) => void) {
    super(new BufferGeometry().setAttribute("position", new Float32BufferAttribute([], 3)), splatMaterial());
    this.frustumCulled = false; // each splat is, and the playhead may move on unnoticed
    this.geometry.boundingBox = new Box3();
    this.geometry.boundingSphere = new Sphere();
    this.onAfterRender = (renderer, _scene, camera, _geometry, material) => {
      // With another material in its place, the host draws something other than a picture, such as depths.
      if (material === this.material) draw(renderer, camera);
    };
  }

  /** Rays never hit it: it has no surface. */
  override raycast(): void {}

  /** Set the bounds of the splats' centres at all times, for three.js' queries. */
  bound(manifest: Manifest): void {
    const box = splatBox(manifest);
    this.geometry.boundingBox = box;
    this.geometry.boundingSphere = box.getBoundingSphere(new Sphere());
  }

  override dispose(): void {
    super.dispose();
    this.geometry.dispose();
    this.material.dispose();
  }
}
