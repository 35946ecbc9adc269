/** `<hgs-player>` in templates of Svelte: `import "@hgs/player/svelte"`. */

import type { HTMLAttributes } from "svelte/elements";
import type { HgsPlayerAttributes, HgsPlayerListeners } from "./element_attributes";
import type { HgsPlayerElement } from "./player_element";

export { HgsPlayerElement } from "./define";

/** Attributes, properties and listeners of the element. */
export type HgsPlayerProps = Omit<HTMLAttributes<HgsPlayerElement>, keyof HgsPlayerListeners> &
  HgsPlayerAttributes &
  HgsPlayerListeners;

declare module "svelte/elements" {
  interface SvelteHTMLElements {
    "hgs-player": HgsPlayerProps;
  }
}
