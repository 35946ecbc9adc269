import { LogLevel, SceneRevealMode, Viewer } from "@mkkellogg/gaussian-splats-3d";
import { threeHost } from "./three_host";
import type { OpenViewer } from "./viewer";

export const openGaussianSplats3D: OpenViewer = async (request) => {
  const { renderer, camera, look, gl } = threeHost(request);
  look(request.camera);
  const viewer = new Viewer({
    selfDrivenMode: false,
    useBuiltInControls: false,
    renderer,
    camera,
    rootElement: request.host,
    ignoreDevicePixelRatio: true,
    sphericalHarmonicsDegree: 0,
    sharedMemoryForWorkers: true,
    sceneRevealMode: SceneRevealMode.Instant,
    cameraUp: request.camera.up,
    logLevel: LogLevel.None,
  });
  await viewer.addSplatScene(new URL("scene.ply", request.files).href, {
    showLoadingUI: false,
    progressiveLoad: false,
    splatAlphaRemovalThreshold: 1,
  });
  return {
    gl,
    look,
    draw: () => {
      viewer.update();
      viewer.render();
    },
    busy: () => Boolean(viewer.sortRunning),
  };
};
