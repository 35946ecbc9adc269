/** The shared view of a scene in a link: the parameters of a viewer page's address. */

import type { Viewing } from "../player/viewpoint";

export interface SharedView {
  /** Seconds on the scene's clock. */
  readonly time: number;
  /** Whether the scene is paused. */
  readonly paused: boolean;
  /** The capture camera with the view's lens; null for the first. */
  readonly camera: string | null;
  readonly view: Viewing | null;
  /** Seconds. */
  readonly loopRange: readonly [number, number] | null;
  readonly bookmarks: readonly number[];
  /** Whether only moving splats are drawn; null for the scene's own choice. */
  readonly subjectOnly: boolean | null;
}

/** Seven digits: a millionth of the scene's size, far below a pixel. */
const short = (value: number): string => String(Number(value.toPrecision(7)));
const list = (values: readonly number[]): string => values.map(short).join(",");

/** The address of a viewer page with a view; further parameters of `page`, such as `antialiased`, stay. */
export function sharedLink(page: string, shared: SharedView): string {
  const { time, paused, camera, view, loopRange, bookmarks, subjectOnly } = shared;
  return withParameters(page, {
    t: short(time),
    paused: paused ? "1" : null,
    camera,
    view: view && list([...view.position, ...view.target, ...view.up]),
    loop: loopRange && list(loopRange),
    marks: list(bookmarks) || null,
    subject: subjectOnly === null ? null : String(Number(subjectOnly)),
  });
}

/** The same address with other bookmarks. */
export const linkWithBookmarks = (page: string, bookmarks: readonly number[]): string =>
  withParameters(page, { marks: list(bookmarks) || null });

/** The same address with other key frames of a camera path, as numbers. */
export const linkWithKeys = (page: string, numbers: readonly number[]): string =>
  withParameters(page, { keys: list(numbers) || null });

/** The address with these parameters; null removes one. */
function withParameters(page: string, parameters: Readonly<Record<string, string | null>>): string {
  const address = new URL(page);
  for (const [name, value] of Object.entries(parameters)) {
    if (value === null) address.searchParams.delete(name);
    else address.searchParams.set(name, value);
  }
  address.search = address.searchParams.toString().replaceAll("%2C", ","); // commas need no escape
  return address.href;
}
