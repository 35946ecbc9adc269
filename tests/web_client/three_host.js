/** A host of three.js for tests: pictures of its scene, with what is asked for in it. */
import * as THREE from "three";
import { HgsScene } from "@hgs/player/three";
import { DrawnHost, encode } from "./drawn_host.js";

/** Two numbers of a projection matrix, for its row of depths. */
const DEPTHS = {
  plain: (near, far) => [-(far + near) / (far - near), (-2 * far * near) / (far - near)],
  reversed: (near, far) => [near / (far - near), (far * near) / (far - near)],
  webgpu: (near, far) => [-far / (far - near), (-far * near) / (far - near)],
};

/** A PerspectiveCamera with just these intrinsics (pixels) and pose (rows of the 4x4 matrix from world to OpenCV camera). */
function cameraOf({ width, height, fx, fy, cx, cy, near, far, rows }, depths) {
  const camera = new THREE.PerspectiveCamera(50, width / height, near, far);
  const [a, b] = DEPTHS[depths](near, far);
  const place = () =>
    camera.projectionMatrix.set(
      ...[(2 * fx) / width, 0, 1 - (2 * cx) / width, 0],
      ...[0, (2 * fy) / height, (2 * cy) / height - 1, 0],
      ...[0, 0, a, b],
      ...[0, 0, -1, 0],
    );
  camera.updateProjectionMatrix = place; // three.js calls it, too
  place();
  const view = new THREE.Matrix4().set(...rows[0], ...rows[1].map((v) => -v), ...rows[2].map((v) => -v), ...rows[3]);
  camera.matrixWorld.copy(view).invert();
  camera.matrixWorld.decompose(camera.position, camera.quaternion, camera.scale);
  return camera;
}

/** A texture that no other one is like: upside down and multiplied by alpha, or not. */
function texture(seed, flipY) {
  const [width, height] = [6, 5];
  const data = new Uint8Array(4 * width * height).map((_, i) => (i * 37 + seed * 91) % 256);
  const made = new THREE.DataTexture(data, width, height);
  made.flipY = flipY;
  made.premultiplyAlpha = flipY;
  made.unpackAlignment = flipY ? 1 : 8;
  made.colorSpace = THREE.SRGBColorSpace;
  made.needsUpdate = true;
  return made;
}

export class Host extends DrawnHost {
  Scene = HgsScene;

  constructor({ width, height, background = [0, 0, 0], renderer = {}, pixelRatio = 1 }) {
    super();
    this.renderer = this.rendererOf({ antialias: false, ...renderer });
    this.renderer.setPixelRatio(pixelRatio);
    this.renderer.setSize(width / pixelRatio, height / pixelRatio);
    this.clearTo = () => this.renderer.setClearColor(new THREE.Color().setRGB(...background, THREE.SRGBColorSpace), 1);
    this.clearTo();
    document.body.append(this.renderer.domElement);
    [this.width, this.height] = [width, height];
    this.world = new THREE.Scene();
    this.draw = () => this.renderer.render(this.world, this.camera);
  }

  /** Give everything back. */
  close() {
    this.splats?.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss?.();
    this.renderer.domElement.remove();
  }

  rendererOf(options) {
    return new THREE.WebGLRenderer(options);
  }

  get depths() {
    return this.renderer.capabilities.reversedDepthBuffer ? "reversed" : "plain";
  }

  look(camera) {
    this.camera = cameraOf(camera, this.depths);
  }

  addSplats(options, place) {
    this.splats = new this.Scene(options);
    if (place) this.splats.applyMatrix4(new THREE.Matrix4().set(...place.flat()));
    this.hear((type, listener) => this.splats.addEventListener(type, ({ detail }) => listener(detail)));
    this.world.add(this.splats);
  }

  /** Draw, and read the canvas: rows from the top, RGBA. */
  pixels() {
    this.draw();
    return this.pixelsOf(this.renderer.domElement);
  }

  /** Draw into a target of floats, at a corner of it, and read that: floats, or halves of several samples a pixel. */
  async floats(offset = 0, samples = 0) {
    const { width, height } = this;
    const target = new THREE.WebGLRenderTarget(width + offset, height + offset, { type: samples ? THREE.HalfFloatType : THREE.FloatType, samples });
    target.viewport.set(offset, offset, width, height);
    this.renderer.setRenderTarget(target);
    this.draw();
    this.renderer.setRenderTarget(null);
    const data = new (samples ? Uint16Array : Float32Array)(4 * width * height);
    this.renderer.readRenderTargetPixels(target, offset, offset, width, height, data);
    target.dispose();
    return encode(new Uint8Array(data.buffer));
  }

  /** A square that faces the camera at a depth, all over the picture or `size` wide; of one colour of sRGB. */
  addWall(depth, { size = 1000, at = [0, 0], colour = [1, 0, 1] } = {}) {
    const material = new THREE.MeshBasicMaterial({ color: new THREE.Color().setRGB(...colour, THREE.SRGBColorSpace) });
    const wall = new THREE.Mesh(new THREE.PlaneGeometry(size, size), material);
    wall.position.set(...at, -depth).applyMatrix4(this.camera.matrixWorld);
    wall.quaternion.copy(this.camera.quaternion);
    this.world.add(wall);
    return wall;
  }

  /** Things with textures before the camera: opaque, transparent, and drawn after the splats. */
  addThings() {
    for (let i = 0; i < 4; i++) {
      const shared = this.world.children.at(-1)?.material?.map;
      const map = i === 2 ? shared : texture(i, i % 2 === 0); // what is bound before the splats is wanted after them
      const material = new THREE.MeshBasicMaterial({ map, transparent: i > 1, opacity: i > 1 ? 0.7 : 1 });
      const thing = new THREE.Mesh(new THREE.BoxGeometry(0.6, 0.6, 0.6), material);
      thing.position.set(i * 0.7 - 1, i * 0.2 - 0.3, -3 - 0.1 * i).applyMatrix4(this.camera.matrixWorld);
      thing.rotation.set(i, 2 * i, 0);
      thing.renderOrder = i === 3 ? 1 : 0;
      this.world.add(thing);
    }
  }

  /** Bind what three.js itself never does, and have textures filled in ways that splats must not be. */
  bind() {
    const { renderer } = this;
    const gl = renderer.getContext();
    this.sampler = gl.createSampler();
    gl.samplerParameteri(this.sampler, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    for (let unit = 0; unit < 6; unit++) gl.bindSampler(unit, this.sampler);
    renderer.initTexture(texture(0, true));
    gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 4096);
    gl.pixelStorei(gl.UNPACK_SKIP_ROWS, 1);
    this.buffer = gl.createBuffer();
    gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, this.buffer);
  }

  /** What of that is still bound. */
  bound() {
    const gl = this.renderer.getContext();
    const samplers = [0, 1, 2, 3, 4, 5].map((unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      return gl.getParameter(gl.SAMPLER_BINDING) === this.sampler;
    });
    gl.activeTexture(gl.TEXTURE0);
    const names = ["UNPACK_ROW_LENGTH", "UNPACK_SKIP_ROWS", "UNPACK_FLIP_Y_WEBGL", "UNPACK_PREMULTIPLY_ALPHA_WEBGL"];
    const unpacking = names.map((name) => gl.getParameter(gl[name]));
    return [samplers, unpacking, gl.getParameter(gl.PIXEL_UNPACK_BUFFER_BINDING) === this.buffer];
  }

  /** Pictures of as many frames; in each the textures of some things are filled anew. */
  async frames(first, count) {
    const pictures = [];
    for (let frame = first; frame < first + count; frame++) {
      await new Promise(requestAnimationFrame);
      this.world.traverse(({ material, renderOrder }) => {
        if (!material?.map || (renderOrder === 0 && material.transparent)) return;
        material.map.image.data[frame] = frame * 29;
        material.map.needsUpdate = frame % 2 === 1;
      });
      pictures.push(this.pixels());
    }
    return pictures;
  }

  /** From now on draw two pictures side by side, by the cameras here and there. */
  split(first, second) {
    const cameras = [first, second].map((camera) => cameraOf(camera, this.depths));
    const { renderer, world } = this;
    const width = this.width / 2;
    renderer.setScissorTest(true);
    this.draw = () => {
      cameras.forEach((camera, i) => {
        renderer.setViewport(i * width, 0, width, this.height);
        renderer.setScissor(i * width, 0, width, this.height);
        renderer.render(world, camera);
      });
    };
  }

  /** Have the context taken away, and given back. */
  async loseContext() {
    const canvas = this.renderer.domElement;
    const heard = (type) => new Promise((resolve) => canvas.addEventListener(type, resolve, { once: true }));
    const lost = heard("webglcontextlost");
    this.renderer.forceContextLoss();
    await lost;
    this.draw();
    const restored = heard("webglcontextrestored");
    await new Promise((resolve) => setTimeout(resolve)); // not within the event
    this.renderer.forceContextRestore();
    await restored;
    this.clearTo(); // three.js forgets it
  }
}

Object.assign(window, { Host, THREE });
