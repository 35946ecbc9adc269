/**
 * The splats among the objects of three.js' `WebGPURenderer`: meshes that are drawn one after the other, after all
 * opaque ones. One turns the target's linear light into sRGB, the next draws splats, the last turns it back.
 */

import { cameraFar, cameraNear, viewZToLogarithmicDepth } from "three/tsl";
import {
  Box3,
  BufferGeometry,
  CustomBlending,
  DoubleSide,
  Float32BufferAttribute,
  type Material,
  Mesh,
  MeshBasicMaterial,
  NoBlending,
  type Node,
  NodeMaterial,
  Object3D,
  OneFactor,
  OneMinusSrcAlphaFactor,
  Sphere,
  Vector4,
  type WebGPURenderer,
} from "three/webgpu";
import { magnification } from "../camera/magnification";
import type { Viewport } from "../camera/projection";
import type { Manifest } from "../codec/types";
import type { HostPicture } from "../host/host_drawer";
import type { HostDepth } from "../host/host_view";
import { WaitingSplats } from "../host/waiting_splats";
import type { Shot } from "../renderer/shot";
import type { SplatSink } from "../renderer/splat_drawer";
import { TargetCopy, toLinear, toSrgb, wholeViewport } from "./light_nodes";
import { NodeTextures } from "./node_textures";
import { matchOutputCamera } from "./output_camera";
import { splatBox } from "./splat_box";
import { splatInputs, splatNodes } from "./splat_nodes";
import { threePicture } from "./three_camera";
import type { ThreeDrawer, ThreeDrawing, ThreeTurn } from "./three_drawer";

type Turn = ThreeTurn<WebGPURenderer>;

/** Larger than any deviation, pixels. */
const LARGEST = 1e9;

/** Vertices of no triangle: browsers warn of drawing none. */
const NOTHING = 1;

export class NodeSplats implements ThreeDrawer<WebGPURenderer> {
  readonly object = new Object3D();
  readonly #textures = new NodeTextures();
  readonly #waiting = new WaitingSplats(() => this.#textures.mostRows);
  readonly #inputs = splatInputs(...this.#textures.all);
  readonly #nodes = splatNodes(this.#inputs);
  readonly #before = new TargetCopy();
  readonly #after = new TargetCopy();
  readonly #room = { box: new Box3(), sphere: new Sphere() };
  readonly #viewport = new Vector4();
  readonly #turn: Mesh;
  readonly #first: Mesh;
  readonly #splats: Mesh<BufferGeometry, NodeMaterial>;
  readonly #last: Mesh;
  #filling = false;
  #failure: unknown = null; // the next picture's error
  #disposed = false;

  /**
   * Wait for a renderer.
   *
   * @param linear whether the target holds linear light.
   */
  constructor(
    readonly linear: boolean,
    readonly drawing: ThreeDrawing<WebGPURenderer>,
  ) {
    // Any renderer can draw this one.
    this.#turn = this.#mesh(new MeshBasicMaterial({ colorWrite: false }));
    this.#turn.geometry.setAttribute("position", new Float32BufferAttribute([0, 0, 0], 3));
    this.#first = this.#mesh(nodeMaterial(wholeViewport(), toSrgb(this.#before)));
    this.#splats = this.#mesh(nodeMaterial(this.#nodes.vertexNode, this.#nodes.fragmentNode));
    this.#last = this.#mesh(nodeMaterial(wholeViewport(), toLinear(this.#before, this.#after)));
    Object.assign(this.#splats.material, {
      depthTest: true,
      blending: CustomBlending,
      blendSrc: OneFactor,
      blendDst: OneMinusSrcAlphaFactor,
    });
    // Read by three.js with the target bound: in a target of several textures these materials would spoil all.
    for (const mesh of this.#drawn) Object.defineProperty(mesh, "visible", { get: () => this.#drawable });
    this.#turn.onBeforeRender = (renderer, scene, camera) => {
      for (const { geometry } of this.#drawn) geometry.setDrawRange(0, NOTHING);
      // With another material in their place, the host draws something other than a picture, such as depths.
      if (scene.overrideMaterial === null) drawing.draw(renderer as unknown as WebGPURenderer, camera);
    };
    this.#last.onBeforeRender = (renderer) => {
      if (this.#last.geometry.drawRange.count > NOTHING) this.#after.take(renderer as unknown as WebGPURenderer);
    };
  }

  get sink(): SplatSink {
    return this.#waiting;
  }

  bound(manifest: Manifest): void {
    this.#room.box.copy(splatBox(manifest));
    this.#room.box.getBoundingSphere(this.#room.sphere);
  }

  picture({ renderer, camera, world }: Turn): HostPicture {
    if (!("isWebGPURenderer" in renderer)) {
      throw new Error("this renderer is no WebGPURenderer: import HgsScene from @hgs/player/three instead");
    }
    matchOutputCamera(renderer);
    if (renderer.xr.isPresenting) {
      throw new Error("headsets show splats by a WebGLRenderer only: import HgsScene from @hgs/player/three instead");
    }
    const target = renderer.getRenderTarget();
    if (target && target.textures.length > 1) {
      throw new Error(`the render target has ${target.textures.length} textures: splats are drawn into one only`);
    }
    if (target) this.#viewport.copy(target.viewport);
    else renderer.getViewport(this.#viewport).multiplyScalar(renderer.getPixelRatio());
    const { x, y, z: width, w: height } = this.#viewport.floor();
    return threePicture(camera, world, { x, y, width, height });
  }

  prepare({ renderer }: Turn): Parameters<SplatSink["setOrder"]> | null {
    const textures = this.#textures;
    if (textures.renderer === null) {
      textures.renderer = renderer;
      if (renderer.logarithmicDepthBuffer) {
        this.#splats.material.depthNode = viewZToLogarithmicDepth(this.#nodes.depth.negate(), cameraNear, cameraFar);
      }
      queueMicrotask(() => this.#fill()); // three.js copies no textures in the middle of a picture
    }
    if (textures.renderer !== renderer) {
      throw new Error("this HgsScene has been drawn by another renderer: each needs one of its own");
    }
    if (this.#failure) throw this.#failure;
    const order = this.#filling ? this.#waiting.flush(textures) : null;
    const u = this.#inputs;
    [u.statics.value, u.dynamics.value, u.fifth.value, u.order.value] = textures.all;
    return order;
  }

  setOrder(...order: Parameters<SplatSink["setOrder"]>): void {
    this.#textures.setOrder(...order);
    this.#inputs.order.value = this.#textures.order;
  }

  draw({ renderer }: Turn, viewport: Viewport, shot: Shot, depth: HostDepth): void {
    const { count } = this.#textures;
    if (count === 0) return;
    const u = this.#inputs;
    const { pose, camera } = shot;
    u.rotation.value.set(...pose.rotation);
    u.translation.value.set(...pose.translation);
    u.focal.value.set(camera.fx, camera.fy);
    u.centre.value.set(camera.cx, camera.cy);
    u.size.value.set(camera.width, camera.height);
    u.origin.value.set(viewport.x, viewport.y);
    u.time.value = shot.time;
    u.near.value = camera.near;
    u.antialiased.value = shot.antialiased ? 1 : 0;
    u.magnification.value.set(...magnification(shot.rig, pose, camera));
    u.still.value = shot.still ?? 1;
    u.closeUp.value.set(shot.clear ?? 0, shot.widest ?? LARGEST);
    u.depthZ.value.set(...depth.z);
    u.depthW.value.set(...depth.w);
    this.#splats.geometry.setDrawRange(0, 3 * count);
    if (!this.linear) return;
    this.#before.take(renderer);
    for (const { geometry } of [this.#first, this.#last]) geometry.setDrawRange(0, 3);
  }

  dispose(): void {
    this.#disposed = true;
    for (const { geometry, material } of [this.#turn, ...this.#drawn]) {
      geometry.dispose();
      (material as Material).dispose();
    }
    for (const { texture } of [this.#before, this.#after]) texture.dispose();
    this.#textures.dispose();
  }

  /** Have splats written to the textures, from now on as they come. */
  #fill(): void {
    if (this.#disposed) return;
    this.#filling = true;
    try {
      this.#waiting.pass(this.#textures);
    } catch (error) {
      this.#failure = error;
    }
  }

  get #drawable(): boolean {
    const { renderer } = this.#textures;
    return renderer !== null && !renderer.xr.isPresenting && (renderer.getRenderTarget()?.textures.length ?? 1) === 1;
  }

  get #drawn(): [Mesh, Mesh, Mesh] {
    return [this.#first, this.#splats, this.#last];
  }

  /** One of the meshes. They are drawn in the order of their making, because they are all in one place. */
  #mesh<M extends Material>(material: M): Mesh<BufferGeometry, M> {
    material.transparent = true;
    const geometry = new BufferGeometry();
    geometry.boundingBox = this.#room.box;
    geometry.boundingSphere = this.#room.sphere;
    const mesh = new Mesh(geometry, material);
    mesh.frustumCulled = false;
    mesh.raycast = () => {}; // no surface
    this.object.add(mesh);
    return mesh;
  }
}

function nodeMaterial(vertexNode: Node<"vec4">, fragmentNode: Node<"vec4">): NodeMaterial {
  const fixed = { depthTest: false, depthWrite: false, blending: NoBlending, fog: false };
  const single = { side: DoubleSide, forceSinglePass: true };
  return Object.assign(new NodeMaterial(), { name: "HgsScene", vertexNode, fragmentNode, ...fixed, ...single });
}
