/** Round buttons with an icon. */

import { icon } from "../dom/element";

/** Turn a button or a link into a round one with an icon. */
export function dress(round: HTMLElement, label: string, path: string): HTMLElement {
  if (round instanceof HTMLButtonElement) round.type = "button";
  round.className = "round";
  round.title = label;
  round.setAttribute("aria-label", label);
  round.append(icon(path));
  return round;
}
