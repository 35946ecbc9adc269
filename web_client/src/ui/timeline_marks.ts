/** The marks on the timeline: bookmarks, and the repeated stretch. */

import { element } from "../dom/element";
import { adoptStyle } from "../dom/shadow_style";
import type { HgsPlayer } from "../player/hgs_player";
import type { Bookmarks } from "./bookmarks";
import css from "./timeline_marks.css?inline";

/** The bar below its marks. */
interface MarkedBar {
  readonly node: HTMLElement;
  readonly player: HgsPlayer;
  readonly bookmarks: Bookmarks;
}

/** Replace the displayed marks by the present ones. */
export function showMarks({ node, player, bookmarks }: MarkedBar): void {
  const { start, duration, loopRange } = player;
  const place = (mark: HTMLElement, places: Record<string, number>): HTMLElement => {
    for (const [name, time] of Object.entries(places))
      mark.style.setProperty(name, ((time - start) / duration).toFixed(4));
    return mark;
  };
  const range = loopRange
    ? [place(element("span", { class: "loop-range" }), { "--from": loopRange[0], "--to": loopRange[1] })]
    : [];
  const marks = bookmarks.times.map((time) => place(element("span", { class: "mark" }), { "--at": time }));
  adoptStyle(node.getRootNode() as ShadowRoot, css);
  node.querySelector(".marks")?.remove();
  node.append(element("span", { class: "marks" }, ...range, ...marks));
}
