/** The parameters of a viewer page's address, for sharing a view and for tests. */

import type { Vec3 } from "../camera/vector";
import { KEY_NUMBERS } from "../keyframes/camera_path";
import type { Viewing } from "../player/viewpoint";

export interface ViewParameters {
  /** `t`: seconds on the scene's clock; null for the start. */
  readonly time: number | null;
  /** `camera`: name of a capture camera; null for the first. */
  readonly camera: string | null;
  /**
   * `view`: the camera's position, the target in the middle of the picture, and the upward direction, as nine numbers;
   * null for none.
   */
  readonly view: Viewing | null;
  /** `loop`: start and end of the repeated stretch, seconds; null for none. */
  readonly loopRange: readonly [number, number] | null;
  /** `marks`: bookmarks, seconds. */
  readonly bookmarks: readonly number[];
  /** `keys`: key frames of a camera path: time, position, target and vertical angle, eight numbers each. */
  readonly keys: readonly number[];
  /** `paused`: 1 to pause, 0 to play; null to play unless the visitor's system asks for less motion. */
  readonly paused: boolean | null;
  /** `width`, `height`: size of the picture in CSS pixels and in its backing store; null to fill the window. */
  readonly size: { readonly width: number; readonly height: number } | null;
  /** `exact`: 1 for the picture alone, from exactly the capture camera's pose and intrinsics. */
  readonly exact: boolean;
  /**
   * `antialiased`: 1 to fade splats thinner than a pixel, 0 not to, for comparisons; null for the scene's own setting.
   */
  readonly antialiased: boolean | null;
  /** `splats`: largest number of splats, the most useful ones; `undefined` for all. */
  readonly splatBudget: number | undefined;
  /** `subject`: 1 for moving splats alone, 0 for all; null for the scene's own choice. */
  readonly subjectOnly: boolean | null;
}

const LARGEST = 8192;

/**
 * Parse an address's query.
 *
 * @throws Error that names the wrong parameter.
 */
export function parseViewParameters(search: string): ViewParameters {
  const parameters = new URLSearchParams(search);

  const finite = (name: string): number | null => {
    const text = parameters.get(name);
    if (text === null) return null;
    const value = Number(text);
    if (text.trim() === "" || !Number.isFinite(value))
      throw new Error(`${name}=${text} in the address is not a number`);
    return value;
  };
  const pixels = (name: string): number | null => {
    const value = finite(name);
    if (value !== null && !(Number.isInteger(value) && value >= 1 && value <= LARGEST)) {
      throw new Error(`${name}=${value} in the address is not a whole number from 1 to ${LARGEST}`);
    }
    return value;
  };
  const flag = (name: string): boolean | null => {
    const text = parameters.get(name);
    if (text !== null && text !== "0" && text !== "1") throw new Error(`${name}=${text} in the address is not 0 or 1`);
    return text === null ? null : text === "1";
  };

  const numbers = (name: string, count: number | null): number[] | null => {
    const text = parameters.get(name);
    if (text === null) return null;
    const values = text.split(",").map((part) => (part.trim() === "" ? Number.NaN : Number(part)));
    if (!values.every(Number.isFinite) || (count !== null && values.length !== count)) {
      const wanted = count === null ? "a list of numbers" : `${count} numbers`;
      throw new Error(`${name}=${text} in the address is not ${wanted}, separated by commas`);
    }
    return values;
  };

  const splats = finite("splats");
  if (splats !== null && !(splats >= 1)) throw new Error(`splats=${splats} in the address is not at least 1`);
  const view = numbers("view", 9);
  const loop = numbers("loop", 2);
  if (loop && !(loop[0] < loop[1])) throw new Error(`loop=${loop} in the address does not begin before it ends`);
  const keys = numbers("keys", null) ?? [];
  const times = keys.filter((_, i) => i % KEY_NUMBERS === 0);
  if (keys.length % KEY_NUMBERS !== 0 || times.some((time, i) => i > 0 && time <= times[i - 1])) {
    throw new Error(`keys in the address are not ${KEY_NUMBERS} numbers each, in order of time`);
  }
  const width = pixels("width");
  const height = pixels("height");
  if ((width === null) !== (height === null)) throw new Error("the address needs both width and height, or neither");
  return {
    time: finite("t"),
    camera: parameters.get("camera"),
    view: view && {
      position: view.slice(0, 3) as unknown as Vec3,
      target: view.slice(3, 6) as unknown as Vec3,
      up: view.slice(6) as unknown as Vec3,
    },
    loopRange: loop && [loop[0], loop[1]],
    bookmarks: numbers("marks", null) ?? [],
    keys,
    paused: flag("paused"),
    size: width !== null && height !== null ? { width, height } : null,
    exact: flag("exact") ?? false,
    antialiased: flag("antialiased"),
    splatBudget: splats ?? undefined,
    subjectOnly: flag("subject"),
  };
}
