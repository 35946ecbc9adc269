import { FreeCamera } from "@babylonjs/core/Cameras/freeCamera";
import { Engine } from "@babylonjs/core/Engines/engine";
import { Color4 } from "@babylonjs/core/Maths/math.color";
import { Vector3 } from "@babylonjs/core/Maths/math.vector";
import { GaussianSplattingMesh } from "@babylonjs/core/Meshes/GaussianSplatting/gaussianSplattingMesh";
import { Scene } from "@babylonjs/core/scene";
import { canvasOf, type OpenViewer } from "./viewer";

export const openBabylon: OpenViewer = async (request) => {
  const engine = new Engine(canvasOf(request), false, {}, false);
  const scene = new Scene(engine);
  scene.useRightHandedSystem = true;
  scene.clearColor = new Color4(0, 0, 0, 1);
  const camera = new FreeCamera("camera", new Vector3(...request.camera.eye), scene);
  camera.fov = (request.camera.fovY * Math.PI) / 180;
  camera.minZ = request.camera.near;
  camera.maxZ = request.camera.far;
  const mesh = new GaussianSplattingMesh("splats", null, scene, true);
  await mesh.loadDataAsync(await (await fetch(new URL("scene.splat", request.files))).arrayBuffer());
  return {
    gl: (engine as unknown as { _gl: WebGL2RenderingContext })._gl,
    look: ({ eye, target, up }) => {
      camera.position.set(...eye);
      camera.upVector.set(...up);
      camera.setTarget(new Vector3(...target));
    },
    draw: () => scene.render(),
  };
};
