/** `<hgs-player>` in JSX of React 19: `import "@hgs/player/react"`. */

import type { ClassAttributes, HTMLAttributes } from "react";
import type { HgsPlayerAttributes, HgsPlayerElementEvent, HgsPlayerListeners } from "./element_attributes";
import type { HgsPlayerElement } from "./player_element";

export { HgsPlayerElement } from "./define";

/** React's own listeners of the same events, such as `onPlay`: it never calls them for other elements than its own. */
type Uncalled<K> = K extends `on${string}`
  ? Lowercase<K> extends `on${HgsPlayerElementEvent}` | `on${HgsPlayerElementEvent}capture`
    ? K
    : never
  : never;

type Common = HTMLAttributes<HgsPlayerElement>;

/** Attributes, properties and listeners of the element. */
export type HgsPlayerProps = ClassAttributes<HgsPlayerElement> &
  Omit<Common, Uncalled<keyof Common>> &
  HgsPlayerAttributes &
  HgsPlayerListeners;

declare module "react" {
  namespace JSX {
    interface IntrinsicElements {
      "hgs-player": HgsPlayerProps;
    }
  }
}
