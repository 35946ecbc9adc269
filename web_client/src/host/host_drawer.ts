/** A drawer of splats in a host's pictures: one for each kind of host. */

import type { Viewport } from "../camera/projection";
import type { Manifest } from "../codec/types";
import type { Shot } from "../renderer/shot";
import type { SplatSink } from "../renderer/splat_drawer";
import type { HostDepth, HostLens } from "./host_view";

/** A part of the bound target, and the lens of the host's camera for it. */
export interface HostPicture extends HostLens {
  readonly viewport: Viewport;
}

/** `Turn` is all that a host says of the moment to draw, such as its renderer and camera. */
export interface HostDrawer<Turn> {
  /** The sink for decoded splats and their order, at any time. */
  readonly sink: SplatSink;
  /** Set the bounds of the splats' centres at all times, for the host's queries. */
  bound(manifest: Manifest): void;
  /**
   * The picture that the host draws; null if there is none at present.
   *
   * @throws Error with one line for people if splats cannot be drawn there.
   */
  picture(turn: Turn): HostPicture | null;
  /**
   * Take the splats received since the last frame.
   *
   * @returns the new order, if there is one: ids and their number, in a borrowed array.
   * @throws Error if another renderer has drawn the scene before, or the device cannot hold it.
   */
  prepare(turn: Turn): Parameters<SplatSink["setOrder"]> | null;
  /** Replace the last order by an earlier one. */
  setOrder(...order: Parameters<SplatSink["setOrder"]>): void;
  /** Draw a shot into the bound target. */
  draw(turn: Turn, viewport: Viewport, shot: Shot, depth: HostDepth): void;
  dispose(): void;
}

export interface HostDrawing<Turn> {
  /** It is the splats' turn in a picture of the host's. */
  draw(turn: Turn): void;
  /** The host's context was restored: then splats and an order must be set again. */
  restored(): void;
}
