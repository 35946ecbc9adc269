/** The camera by which three.js' `WebGPURenderer` copies its pictures to the canvas: one for all renderers of a page. */

import { NodeMaterial, QuadMesh, type WebGPURenderer } from "three/webgpu";

const { camera } = new QuadMesh(new NodeMaterial());

/**
 * Give that camera the depths of a renderer.
 *
 * three.js (r187) gives it reversed ones for a renderer with `reversedDepthBuffer` and never takes them back: then the
 * canvas of every other renderer stays empty.
 */
export function matchOutputCamera(renderer: WebGPURenderer): void {
  if (renderer.reversedDepthBuffer || !camera.reversedDepth) return;
  Object.assign(camera, { _reversedDepth: false }); // it has no setter
  camera.updateProjectionMatrix();
}
