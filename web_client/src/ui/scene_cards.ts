/** The scenes as cards: thumbnail, title, length, size. */

import { type Scene, thumbnailUrl } from "../protocol/api";
import { element, icon } from "./element";
import { formatBytes, formatCount, formatDuration } from "./format";
import { PLAY } from "./icons";

function card(scene: Scene): HTMLElement {
  const moving = scene.splats_dynamic > 0;
  const figures = [
    formatBytes(scene.bytes_total),
    `${formatCount(scene.splats_static + scene.splats_dynamic)} splats`,
    moving
      ? `${Math.round((100 * scene.splats_dynamic) / (scene.splats_static + scene.splats_dynamic))}% moving`
      : "still",
  ];
  const picture = element("img", { src: thumbnailUrl(scene.id), alt: "", loading: "lazy", width: 320, height: 180 });
  picture.addEventListener("error", () => picture.remove()); // the placeholder behind it shows
  const length = scene.end - scene.start;
  return element(
    "li",
    {},
    element(
      "a",
      { class: "card", href: `/view/${encodeURIComponent(scene.id)}` },
      element(
        "div",
        { class: "card-picture" },
        picture,
        element("span", { class: "card-play" }, icon(PLAY)),
        length > 0 ? element("span", { class: "card-length" }, formatDuration(length)) : null, // a still scene has none
      ),
      element("h3", { class: "card-title" }, scene.title || scene.id),
      element("p", { class: "card-figures" }, figures.join(" · ")),
    ),
  );
}

/** Fill `list` with the scenes; rebuilt only when they have changed. */
export function showScenes(list: HTMLElement, scenes: readonly Scene[]): void {
  const version = JSON.stringify(scenes);
  if (list.dataset.version === version) return;
  list.dataset.version = version;
  list.replaceChildren(...scenes.map(card));
}
