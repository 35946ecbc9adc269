/** `<hgs-player>` in templates of Vue: `import "@hgs/player/vue"`. */

import type { HTMLAttributes, PublicProps } from "vue";
import type { CapitalisedListeners, HgsPlayerAttributes } from "./element_attributes";
import type { HgsPlayerElement } from "./player_element";

export { HgsPlayerElement } from "./define";

/** Attributes, properties and listeners of the element. */
export type HgsPlayerProps = Omit<HTMLAttributes, keyof CapitalisedListeners> &
  PublicProps &
  HgsPlayerAttributes &
  CapitalisedListeners;

declare module "vue" {
  interface GlobalComponents {
    /** The element with the types of its templates: it has no `$props`. */
    "hgs-player": new () => HgsPlayerElement & { $props: HgsPlayerProps };
  }
}
