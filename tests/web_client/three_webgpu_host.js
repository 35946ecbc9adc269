/** A host of three.js' WebGPURenderer for tests. */
import * as THREE from "three/webgpu";
import { mrt, output, vec4 } from "three/tsl";
import { WebGLRenderer } from "three/webgl";
import { HgsScene as OfWebGL } from "@hgs/player/three";
import { HgsScene } from "@hgs/player/three-webgpu";
import { encode } from "./drawn_host.js";
import { Host } from "./three_host.js";

class NodeHost extends Host {
  Scene = HgsScene;

  rendererOf(options) {
    return new THREE.WebGPURenderer(options);
  }

  get depths() {
    if (this.renderer.reversedDepthBuffer) return "reversed";
    return this.renderer.backend.isWebGPUBackend ? "webgpu" : "plain";
  }

  /** Draw into a target of half floats and read that: rows from the top. */
  async halves(samples = 0) {
    const { width, height } = this;
    const target = new THREE.RenderTarget(width, height, { type: THREE.HalfFloatType, samples });
    this.renderer.setRenderTarget(target);
    this.draw();
    this.renderer.setRenderTarget(null);
    const data = await this.renderer.readRenderTargetPixelsAsync(target, 0, 0, width, height);
    target.dispose();
    return encode(new Uint8Array(data.buffer));
  }

  /** Draw into a target of two textures. */
  drawToTwo() {
    const target = new THREE.RenderTarget(this.width, this.height, { count: 2 });
    target.textures.forEach((texture, i) => { texture.name = ["output", "normal"][i]; });
    this.renderer.setRenderTarget(target);
    this.renderer.setMRT(mrt({ output, normal: vec4(1) }));
    this.draw();
    this.renderer.setMRT(null);
    this.renderer.setRenderTarget(null);
    target.dispose();
  }
}

Object.assign(window, { NodeHost, THREE, OfWebGL, WebGLRenderer });
