/** The layout of the controls on the panel in front of the viewer. */

import { add, dot, row, scale, subtract, type Vec3 } from "../camera/vector";
import type { RoomPose } from "./eye_camera";
import { transpose } from "./similarity";

export type Control = "play" | "seek" | "reset" | "mute" | "leave";

export interface Rectangle {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** Size in metres. */
export const PANEL = { width: 0.64, height: 0.2 };
/** Size of its picture, pixels. */
export const PIXELS = { width: 1024, height: 320 };

/** Places in pixels of the picture, from its top left corner. */
export const CONTROLS: Readonly<Record<Control, Rectangle>> = {
  play: { x: 24, y: 24, width: 136, height: 136 },
  seek: { x: 192, y: 24, width: 808, height: 136 },
  reset: { x: 24, y: 184, width: 300, height: 84 },
  mute: { x: 712, y: 184, width: 144, height: 84 },
  leave: { x: 868, y: 184, width: 132, height: 84 },
};

/** The bar within the control `seek`. */
export const BAR: Rectangle = { x: 208, y: 56, width: 776, height: 20 };

/** The control at a point of the picture. */
export function controlAt(x: number, y: number): Control | null {
  const inside = ({ x: left, y: top, width, height }: Rectangle) =>
    x >= left && x < left + width && y >= top && y < top + height;
  return (Object.keys(CONTROLS) as Control[]).find((name) => inside(CONTROLS[name])) ?? null;
}

/** The share of the scene's duration at a point of the bar. */
export const shareAt = (x: number): number => Math.min(1, Math.max(0, (x - BAR.x) / BAR.width));

export interface Ray {
  readonly origin: Vec3;
  readonly direction: Vec3; // unit vector
}

/** The intersection of a ray with the panel's plane. */
export interface PanelPoint {
  /** Pixels of the picture; may be outside it. */
  readonly x: number;
  readonly y: number;
  /** Metres from the ray's origin. */
  readonly distance: number;
}

/** The ray of a pointer: along its own forward axis. */
export const rayOf = ({ position, rotation }: RoomPose): Ray => ({
  origin: position,
  direction: scale(row(transpose(rotation), 2), -1),
});

/** The intersection of a ray with the plane of a panel with its middle at `panel`; null if there is none. */
export function pointOn(panel: RoomPose, { origin, direction }: Ray): PanelPoint | null {
  const axes = transpose(panel.rotation); // rows: right, up, towards the viewer
  const facing = dot(direction, row(axes, 2));
  if (facing > -1e-6) return null; // parallel to it, or from behind
  const distance = dot(subtract(panel.position, origin), row(axes, 2)) / facing;
  if (distance < 0) return null;
  const hit = subtract(add(origin, scale(direction, distance)), panel.position);
  return {
    x: (dot(hit, row(axes, 0)) / PANEL.width + 0.5) * PIXELS.width,
    y: (0.5 - dot(hit, row(axes, 1)) / PANEL.height) * PIXELS.height,
    distance,
  };
}

export const onPanel = ({ x, y }: PanelPoint): boolean => x >= 0 && y >= 0 && x < PIXELS.width && y < PIXELS.height;
