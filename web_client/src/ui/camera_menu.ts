/** Chooses a capture camera to look from. */

import { element, icon } from "./element";
import { CAMERA } from "./icons";
import type { Viewpoint } from "./viewpoint";

export class CameraMenu {
  readonly node: HTMLElement;

  constructor(viewpoint: Viewpoint, cameras: readonly string[]) {
    const select = element("select", { "aria-label": "Camera" });
    for (const name of cameras) {
      select.append(element("option", { value: name, selected: name === viewpoint.cameraName }, name));
    }
    select.addEventListener("change", () => viewpoint.look(select.value));
    // Choosing the same camera again goes back to it, too.
    const again = element(
      "button",
      { type: "button", class: "round small", title: "Back to this camera (0)", onclick: () => viewpoint.reset() },
      icon(CAMERA),
    );
    again.setAttribute("aria-label", "Back to this camera");
    this.node = element("div", { class: "camera-menu", hidden: cameras.length === 0 }, again, select);
  }
}
