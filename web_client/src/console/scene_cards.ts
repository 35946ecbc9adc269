/** The scenes as cards: thumbnail, title, length, size, growth, and actions. */

import { element, icon } from "../dom/element";
import { formatBytes, formatDuration } from "../dom/format";
import { PLAY } from "../dom/icons";
import { type Scene, thumbnailUrl } from "../protocol/api";
import { siteUrl } from "../protocol/http";
import { type SceneEvents, sceneActions } from "./scene_actions";
import { nameOf } from "./scene_order";
import { showNodes } from "./shell";

function card(scene: Scene, events: SceneEvents): HTMLElement {
  const picture = element("img", { src: thumbnailUrl(scene.id), alt: "", loading: "lazy", width: 320, height: 180 });
  picture.addEventListener("error", () => picture.remove()); // shows the placeholder behind it
  const length = scene.end - scene.start;
  const badge = sceneBadge(scene);
  return element(
    "li",
    { class: "scene" },
    element(
      "a",
      { class: "card", href: siteUrl(`view/${encodeURIComponent(scene.id)}`) },
      element(
        "div",
        { class: "card-picture" },
        picture,
        element("span", { class: "card-play" }, icon(PLAY)),
        badge ? element("span", { class: "card-badge" }, badge) : null,
        length > 0 ? element("span", { class: "card-length" }, formatDuration(length)) : null, // a still scene has none
      ),
      element("h3", { class: "card-title" }, nameOf(scene)),
      element("p", { class: "card-figures" }, describeScene(scene)),
    ),
    sceneActions(scene, events),
  );
}

/** The cards, created once per scene, and again when the scene has changed. */
export class SceneCards {
  #cards = new Map<string, { readonly version: string; readonly node: HTMLElement }>();

  constructor(
    readonly list: HTMLElement,
    readonly events: SceneEvents,
  ) {}

  show(scenes: readonly Scene[]): void {
    const cards = new Map<string, { readonly version: string; readonly node: HTMLElement }>();
    for (const scene of scenes) {
      const version = JSON.stringify(scene);
      const before = this.#cards.get(scene.id);
      cards.set(scene.id, before?.version === version ? before : { version, node: card(scene, this.events) });
    }
    this.#cards = cards;
    showNodes(
      this.list,
      [...cards.values()].map(({ node }) => node),
    );
  }
}

/** "28 Nov 2026 · 1.2 MB", "28 Nov 2026 · 1.2 MB · still" */
export function describeScene({ bytes_total, created, splats_dynamic }: Scene): string {
  const made = new Date(1000 * created).toLocaleDateString("en-GB", {
    day: "numeric",
    month: "short",
    year: "numeric",
  });
  return [made, formatBytes(bytes_total), ...(splats_dynamic > 0 ? [] : ["still"])].join(" · ");
}

/** The note on a growing scene. Empty for a complete one. */
export const sceneBadge = ({ live }: Scene): string => (live ? "Still being made" : "");
