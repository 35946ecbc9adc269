/** The place of the buttons for headsets, which are loaded where the browser and a device offer one. */

import { element } from "../dom/element";
import type { HgsPlayer } from "../player/hgs_player";
import { offeredModes } from "../xr/offer";
import { LatePart } from "./late_part";

/** An element that holds the buttons as soon as there is a use for them, until the player is disposed of. */
export function offerHeadset(player: HgsPlayer, shadow: ShadowRoot): HTMLElement {
  const place = element("div");
  const { xr } = navigator;
  const buttons = new LatePart(
    async () => {
      const { HeadsetButtons } = await import("./headset_buttons"); // for those who have a headset
      return new HeadsetButtons(player, shadow);
    },
    // biome-ignore lint/suspicious/noConsole: nobody has asked for a headset yet
    (message, cause) => console.warn(message, cause),
    player.disposed,
  );
  const offer = async (): Promise<void> => {
    if ((await offeredModes(xr)).length > 0) buttons.use(({ node }) => place.replaceChildren(node));
  };
  void offer();
  xr?.addEventListener("devicechange", () => void offer(), { signal: player.disposed });
  return place;
}
