/** Chooses a capture camera to look from. */

import type { HgsPlayer } from "../player/hgs_player";
import { element, icon } from "./element";
import { CAMERA } from "./icons";

export class CameraMenu {
  readonly node: HTMLElement;

  /** For the scene that the player shows now. */
  constructor({ camera }: HgsPlayer) {
    const select = element("select", { "aria-label": "Camera" });
    for (const name of camera.names) {
      select.append(element("option", { value: name, selected: name === camera.name }, name));
    }
    select.addEventListener("change", () => camera.look(select.value));
    // Choosing the same camera again goes back to it, too.
    const again = element(
      "button",
      { type: "button", class: "round small", title: "Back to this camera (0)", onclick: () => camera.reset() },
      icon(CAMERA),
    );
    again.setAttribute("aria-label", "Back to this camera");
    this.node = element("div", { class: "camera-menu", hidden: camera.names.length === 0 }, again, select);
  }
}
