/** A drawer of splats in a host's pictures: one for each kind of three.js' renderers. */

import type { Camera, Object3D } from "three";
import type { Viewport } from "../camera/projection";
import type { Manifest } from "../codec/types";
import type { Shot } from "../renderer/shot";
import type { SplatSink } from "../renderer/splat_drawer";
import type { HostView } from "./host_view";

export interface HostDrawer<Renderer> {
  /** The sink for decoded splats and their order, at any time. */
  readonly sink: SplatSink;
  /** The splats' representative among the host's objects. */
  readonly object: Object3D;
  /** Set the bounds of the splats' centres at all times, for three.js' queries. */
  bound(manifest: Manifest): void;
  /**
   * The viewport of the bound target, pixels; null if there is none at present.
   *
   * @throws Error with one line for people if splats cannot be drawn there.
   */
  viewport(renderer: Renderer): Viewport | null;
  /**
   * Take the splats received since the last frame.
   *
   * @returns the new order, if there is one: ids and their number, in a borrowed array.
   * @throws Error if another renderer has drawn the scene before, or the device cannot hold it.
   */
  prepare(renderer: Renderer): Parameters<SplatSink["setOrder"]> | null;
  /** Replace the last order by an earlier one. */
  setOrder(...order: Parameters<SplatSink["setOrder"]>): void;
  /** Draw a shot into the bound target. */
  draw(renderer: Renderer, camera: Camera, viewport: Viewport, shot: Shot, depth: HostView["depth"]): void;
  dispose(): void;
}

export interface HostDrawing<Renderer> {
  /** It is the splats' turn in a picture of the host's. */
  draw(renderer: Renderer, camera: Camera): void;
  /** The host's context was restored: then splats and an order must be set again. */
  restored(): void;
}
