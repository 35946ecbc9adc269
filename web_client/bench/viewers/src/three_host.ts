/** A three.js renderer and camera, for the viewers that are built on it. */

import { PerspectiveCamera, WebGLRenderer } from "three";
import type { BenchCamera, BenchRequest } from "./viewer";

export function threeHost({ host, width, height, camera: { fovY, near, far } }: BenchRequest) {
  const renderer = new WebGLRenderer({ antialias: false });
  renderer.setPixelRatio(1);
  renderer.setSize(width, height);
  renderer.setClearColor(0, 1);
  host.append(renderer.domElement);
  const camera = new PerspectiveCamera(fovY, width / height, near, far);
  const look = ({ eye, target, up }: BenchCamera): void => {
    camera.position.set(...eye);
    camera.up.set(...up);
    camera.lookAt(...target);
    camera.updateMatrixWorld();
  };
  return { renderer, camera, look, gl: renderer.getContext() as WebGL2RenderingContext };
}
