/** The picture as a file. */

import { element } from "../dom/element";
import type { HgsPlayer } from "../player/hgs_player";

/** "studio 0m01.20s.png": of a scene's title and a time, seconds; without signs that file systems do not take. */
export function pictureName(title: string, time: number): string {
  const hundredths = Math.round(100 * Math.max(0, time));
  const seconds = ((hundredths % 6000) / 100).toFixed(2).padStart(5, "0");
  const name = title.replace(/[^\p{L}\p{N}._-]+/gu, " ").trim() || "scene";
  return `${name} ${Math.floor(hundredths / 6000)}m${seconds}s.png`;
}

/**
 * Let the browser save what the player shows, at its best quality; returns the name of the file.
 *
 * @throws Error if nothing has been drawn yet.
 */
export async function savePicture(player: HgsPlayer): Promise<string> {
  const name = pictureName(player.manifest?.title ?? "", player.currentTime - player.start);
  const address = URL.createObjectURL(await player.screenshot());
  element("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000); // the browser may read it late
  return name;
}
