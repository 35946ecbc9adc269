/** The time under the pointer, over the timeline. */

import { element, setText } from "../dom/element";
import { formatTime } from "../dom/format";
import { adoptStyle } from "../dom/shadow_style";
import type { HgsPlayer } from "../player/hgs_player";
import css from "./time_bubble.css?inline";

/** Half of the knob's width, the bar's own pixels: the distance of the bar's first and last moment from its ends. */
const KNOB = 8;

/** Show the moment under the pointer from now on; for a finger only while the knob is `dragged`. */
export function showTimes(
  { node, player, dragged }: { node: HTMLElement; player: HgsPlayer; dragged: () => boolean },
  bar: HTMLElement,
  entered: PointerEvent,
): void {
  const bubble = element("span", { class: "bubble", "aria-hidden": "true", hidden: true });
  adoptStyle(node.getRootNode() as ShadowRoot, css);
  node.append(bubble);
  const point = ({ clientX, pointerType }: PointerEvent): void => {
    if (pointerType === "touch" && !dragged()) return;
    const { left, width } = bar.getBoundingClientRect();
    const knob = (KNOB * width) / (bar.offsetWidth || 1); // the bar is enlarged on large screens
    const share = Math.max(0, Math.min(1, (clientX - left - knob) / (width - 2 * knob)));
    setText(bubble, formatTime(share * player.duration));
    bubble.style.setProperty("--at", share.toFixed(4));
    bubble.hidden = false;
  };
  bar.addEventListener("pointermove", point);
  for (const type of ["pointerleave", "pointercancel"]) {
    bar.addEventListener(type, () => {
      bubble.hidden = true;
    });
  }
  if (bar.matches(":hover")) point(entered);
}
