/** A drawer of splats in three.js' pictures: one for each kind of its renderers. */

import type { Camera, Matrix4, Object3D } from "three";
import type { HostDrawer, HostDrawing } from "../host/host_drawer";

/** The splats' turn in a picture of three.js. */
export interface ThreeTurn<Renderer> {
  readonly renderer: Renderer;
  readonly camera: Camera;
  /** From the scene's own space to the host's world. */
  readonly world: Matrix4;
}

export interface ThreeDrawer<Renderer> extends HostDrawer<ThreeTurn<Renderer>> {
  /** The splats' representative among the host's objects. */
  readonly object: Object3D;
}

export interface ThreeDrawing<Renderer> extends Pick<HostDrawing<unknown>, "restored"> {
  /** It is the splats' turn in a picture of the host's. */
  draw(renderer: Renderer, camera: Camera): void;
}
