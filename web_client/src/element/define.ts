/** Registration of `<hgs-player>`: `import "@hgs/player/element"`. */

import { HgsPlayerElement } from "./player_element";

export { HgsPlayerElement };

declare global {
  interface HTMLElementTagNameMap {
    "hgs-player": HgsPlayerElement;
  }
}

// A page may load two copies of this module; the first one wins.
if (import.meta.env.MODE === "site" || globalThis.customElements)
  if (!customElements.get("hgs-player")) customElements.define("hgs-player", HgsPlayerElement);
