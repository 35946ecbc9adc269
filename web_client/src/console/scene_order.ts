/** The filter and the order of the list of scenes. */

import type { Scene } from "../protocol/api";

export const ORDERS = {
  newest: "Newest first",
  name: "By name",
  longest: "Longest first",
  largest: "Largest first",
} as const;

export type Order = keyof typeof ORDERS;

export const isOrder = (text: string): text is Order => Object.hasOwn(ORDERS, text);

const COMPARE: Readonly<Record<Order, (a: Scene, b: Scene) => number>> = {
  newest: (a, b) => b.created - a.created,
  name: (a, b) => nameOf(a).localeCompare(nameOf(b), undefined, { numeric: true, sensitivity: "base" }),
  longest: (a, b) => b.end - b.start - (a.end - a.start),
  largest: (a, b) => b.bytes_total - a.bytes_total,
};

export const nameOf = (scene: Scene): string => scene.title || scene.id;

/** Letters without their accents and in lower case, so that "etude" finds "Étude". */
const plain = (text: string): string => text.normalize("NFD").replace(/\p{M}/gu, "").toLowerCase();

/** The scenes with every word of `search` in their title or id, in an order. */
export function arrange(scenes: readonly Scene[], search: string, order: Order): Scene[] {
  const words = plain(search).split(/\s+/).filter(Boolean);
  const found = scenes.filter((scene) => {
    const text = `${plain(nameOf(scene))} ${scene.id}`;
    return words.every((word) => text.includes(word));
  });
  return found.sort(COMPARE[order]);
}
