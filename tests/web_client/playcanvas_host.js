/** A host of PlayCanvas for tests: pictures of its scene, with what is asked for in it. */
import * as pc from "playcanvas";
import { HgsScene } from "@hgs/player/playcanvas";
import { DrawnHost, encode } from "./drawn_host.js";

/** By columns, of rows. */
const columns = (rows) => [0, 1, 2, 3].flatMap((i) => rows.map((row) => row[i]));

class PlayHost extends DrawnHost {
  constructor({ width, height, background = [0, 0, 0] }) {
    super();
    Object.assign(this, { width, height, background: new pc.Color(...background, 1) });
    this.canvas = Object.assign(document.createElement("canvas"), { width, height });
    document.body.append(this.canvas);
    this.app = new pc.Application(this.canvas, { graphicsDeviceOptions: { antialias: false, alpha: false } });
    this.app.setCanvasFillMode(pc.FILLMODE_NONE, width, height);
    this.app.setCanvasResolution(pc.RESOLUTION_FIXED, width, height);
  }

  /** Give everything back. */
  close() {
    if (this.app.graphicsDevice) this.app.destroy();
    this.canvas.remove();
  }

  draw() {
    if (!this.app.graphicsDevice.contextLost) this.app.render();
  }

  /** A camera with just these intrinsics (pixels) and pose (rows of the 4x4 matrix from world to OpenCV camera). */
  cameraOf({ width, height, fx, fy, cx, cy, near, far, rows }) {
    const entity = new pc.Entity("eye");
    entity.addComponent("camera", { clearColor: this.background, nearClip: near, farClip: far, toneMapping: pc.TONEMAP_NONE });
    entity.camera.calculateProjection = (matrix) =>
      matrix.set(columns([
        [(2 * fx) / width, 0, 1 - (2 * cx) / width, 0],
        [0, (2 * fy) / height, (2 * cy) / height - 1, 0],
        [0, 0, -(far + near) / (far - near), (-2 * far * near) / (far - near)],
        [0, 0, -1, 0],
      ]));
    const view = new pc.Mat4().set(columns(rows.map((row, i) => row.map((v) => (i === 1 || i === 2 ? -v : v)))));
    const place = view.invert();
    entity.setPosition(place.getTranslation());
    entity.setRotation(new pc.Quat().setFromMat4(place));
    this.app.root.addChild(entity);
    return entity;
  }

  look(camera) {
    this.eye?.destroy();
    this.eye = this.cameraOf(camera);
  }

  /** From now on draw two pictures side by side, by the cameras here and there. */
  split(...cameras) {
    cameras.forEach((camera, i) => {
      this.cameraOf(camera).camera.rect = new pc.Vec4(i / 2, 0, 0.5, 1);
    });
  }

  addSplats(options, place) {
    this.splats = new HgsScene(this.app, options);
    if (place) {
      const matrix = new pc.Mat4().set(columns(place));
      this.splats.setPosition(matrix.getTranslation());
      this.splats.setRotation(new pc.Quat().setFromMat4(matrix));
      this.splats.setLocalScale(matrix.getScale());
    }
    this.hear((type, listener) => this.splats.on(type, listener));
    this.app.root.addChild(this.splats);
  }

  pixels() {
    this.draw();
    return this.pixelsOf(this.canvas);
  }

  /** Draw into a target of floats or half floats, in linear light, and read that: rows from the bottom. */
  async light(format, samples = 1) {
    const { width, height, eye: { camera } } = this;
    const colorBuffer = new pc.Texture(this.app.graphicsDevice, { width, height, format: pc[format], mipmaps: false });
    const target = new pc.RenderTarget({ colorBuffer, depth: true, samples });
    const clearColor = new pc.Color().linear(this.background);
    Object.assign(camera, { renderTarget: target, gammaCorrection: pc.GAMMA_NONE, clearColor });
    this.draw();
    const data = await colorBuffer.read(0, 0, width, height);
    Object.assign(camera, { renderTarget: null, gammaCorrection: pc.GAMMA_SRGB, clearColor: this.background });
    target.destroyTextureBuffers();
    target.destroy();
    return encode(new Uint8Array(data.buffer));
  }

  /** From now on draw by a CameraFrame with a target of this format. */
  addFrame(format) {
    const { camera } = this.eye;
    camera.clearColor = new pc.Color().linear(this.background);
    const frame = new pc.CameraFrame(this.app, camera);
    Object.assign(frame.rendering, { renderFormats: [pc[format]], toneMapping: pc.TONEMAP_NONE, samples: 1 });
    frame.update();
  }

  material(settings) {
    const black = new pc.Color(0, 0, 0);
    const fixed = { useLighting: false, useTonemap: false, useFog: false, diffuse: black, cull: pc.CULLFACE_NONE };
    const material = Object.assign(new pc.StandardMaterial(), fixed, settings);
    material.update();
    return material;
  }

  /** A thing before the camera: there in its space, `size` wide. */
  place(type, material, size, ...there) {
    const thing = new pc.Entity(type);
    thing.addComponent("render", { type, material });
    thing.setPosition(this.eye.getWorldTransform().transformPoint(new pc.Vec3(...there)));
    thing.setRotation(this.eye.getRotation().clone().mul(new pc.Quat().setFromEulerAngles(90, 0, 0)));
    thing.setLocalScale(size, size, size);
    this.app.root.addChild(thing);
    return thing;
  }

  /** A square that faces the camera at a depth, all over the picture or `size` wide; of one colour of sRGB. */
  addWall(depth, { size = 1000, at = [0, 0], colour = [1, 0, 1] } = {}) {
    return this.place("plane", this.material({ emissive: new pc.Color(...colour) }), size, ...at, -depth);
  }

  /** Things with textures before the camera, opaque and transparent: nearer than the splats' middle, and farther. */
  addThings() {
    this.things = [0, 1, 2, 3].map((i) => {
      const [width, height] = [6, 5];
      const levels = [new Uint8Array(4 * width * height).map((_, k) => (k * 37 + i * 91) % 256)];
      const options = { width, height, format: pc.PIXELFORMAT_SRGBA8, mipmaps: false, levels, flipY: i % 2 === 0 };
      const emissiveMap = new pc.Texture(this.app.graphicsDevice, options);
      const blending = i > 1 ? { blendType: pc.BLEND_NORMAL, opacity: 0.7, depthWrite: false } : {};
      const material = this.material({ emissive: new pc.Color(1, 1, 1), emissiveMap, ...blending });
      this.place("box", material, 0.6, i * 0.7 - 1, i * 0.2 - 0.3, i === 3 ? -7.9 : -3 - 0.1 * i);
      return emissiveMap;
    });
  }

  /** Pictures of as many frames; in every second one the textures of some things are filled anew. */
  async frames(first, count) {
    const pictures = [];
    for (let frame = first; frame < first + count; frame++) {
      await new Promise(requestAnimationFrame);
      if (frame % 2 === 1) for (const texture of this.things.slice(1)) {
        texture.lock()[4 * frame] = frame * 29;
        texture.unlock();
      }
      pictures.push(this.pixels());
    }
    return pictures;
  }

  /** What the engine and its device hold. */
  held() {
    const { scene, graphicsDevice: device, root } = this.app;
    const meshes = scene.layers.getLayerById(pc.LAYERID_WORLD).meshInstances.length;
    return [device.textures.size, device.buffers.size, device.shaders.length, root.children.length, meshes];
  }

  get error() {
    return this.app.graphicsDevice.gl.getError();
  }

  /** Have the context taken away, and given back. */
  async loseContext() {
    const heard = (type) => new Promise((resolve) => this.canvas.addEventListener(type, resolve, { once: true }));
    const context = this.app.graphicsDevice.gl.getExtension("WEBGL_lose_context");
    const lost = heard("webglcontextlost");
    context.loseContext();
    await lost;
    this.draw();
    const restored = heard("webglcontextrestored");
    await new Promise((resolve) => setTimeout(resolve)); // not within the event
    context.restoreContext();
    await restored;
  }
}

Object.assign(window, { PlayHost, pc, HgsScene });
