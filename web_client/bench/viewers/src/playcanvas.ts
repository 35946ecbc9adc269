import {
  AppBase,
  AppOptions,
  Asset,
  CameraComponentSystem,
  Color,
  createGraphicsDevice,
  DEVICETYPE_WEBGL2,
  Entity,
  FILLMODE_NONE,
  GAMMA_SRGB,
  GSplatComponentSystem,
  GSplatHandler,
  RESOLUTION_FIXED,
  TONEMAP_NONE,
  Vec3,
} from "playcanvas";
import { canvasOf, type OpenViewer } from "./viewer";

export const openPlayCanvas: OpenViewer = async (request) => {
  const canvas = canvasOf(request);
  const device = await createGraphicsDevice(canvas, { deviceTypes: [DEVICETYPE_WEBGL2], antialias: false });
  device.maxPixelRatio = 1;
  const options = new AppOptions();
  options.graphicsDevice = device;
  options.componentSystems = [CameraComponentSystem, GSplatComponentSystem];
  options.resourceHandlers = [GSplatHandler];
  const app = new AppBase(canvas);
  app.init(options);
  app.setCanvasFillMode(FILLMODE_NONE, request.width, request.height);
  app.setCanvasResolution(RESOLUTION_FIXED, request.width, request.height);
  app.start();
  const asset = new Asset("scene", "gsplat", { url: new URL("scene.ply", request.files).href });
  app.assets.add(asset);
  await new Promise<void>((resolve, reject) => {
    asset.ready(() => resolve());
    asset.on("error", reject);
    app.assets.load(asset);
  });
  const camera = new Entity("camera");
  camera.addComponent("camera", {
    clearColor: new Color(0, 0, 0, 1),
    fov: request.camera.fovY,
    nearClip: request.camera.near,
    farClip: request.camera.far,
    toneMapping: TONEMAP_NONE,
    gammaCorrection: GAMMA_SRGB,
  });
  app.root.addChild(camera);
  const splats = new Entity("splats");
  splats.addComponent("gsplat", { asset, unified: true });
  app.root.addChild(splats);
  return {
    gl: (device as unknown as { gl: WebGL2RenderingContext }).gl,
    look: ({ eye, target, up }) => {
      camera.setPosition(new Vec3(...eye));
      camera.lookAt(new Vec3(...target), new Vec3(...up));
    },
  };
};
