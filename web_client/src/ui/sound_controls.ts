/** Mute and volume beside the time, for scenes that have sound. */

import { element, icon, setAttribute } from "../dom/element";
import { adoptStyle } from "../dom/shadow_style";
import type { HgsPlayer } from "../player/hgs_player";
import { isSilent, toggleMuted } from "../sound/muting";
import css from "./sound_controls.css?inline";

const LOUD =
  "M4 9v6h4l5 4.5v-15L8 9zm11.2-1.6v2a3 3 0 0 1 0 5.2v2a5 5 0 0 0 0-9.2zm0-3.9v2a7 7 0 0 1 0 13v2a9 9 0 0 0 0-17z";
const QUIET = "M4 9v6h4l5 4.5v-15L8 9zm11.2-1.6v2a3 3 0 0 1 0 5.2v2a5 5 0 0 0 0-9.2z";
const MUTED =
  "M4 9v6h4l5 4.5v-15L8 9zm17.5 1.2-1.3-1.3-2.2 2.2-2.2-2.2-1.3 1.3 2.2 2.2-2.2 2.2 1.3 1.3 2.2-2.2 2.2 2.2 1.3-1.3-2.2-2.2z";

/** Add the controls to a player's bar, for the present scene. */
export function addSoundControls(player: HgsPlayer, bar: HTMLElement): void {
  adoptStyle(bar.getRootNode() as ShadowRoot, css);
  const mute = element("button", { type: "button", class: "round mute" });
  const volume = element("input", {
    type: "range",
    class: "volume",
    "aria-label": "Volume",
    min: 0,
    max: 1,
    step: 0.05,
  });
  let shown = "";
  const update = () => {
    const silent = isSilent(player);
    const level = silent ? 0 : player.volume;
    volume.value = String(level);
    volume.style.setProperty("--share", String(level));
    setAttribute(volume, "aria-valuetext", silent ? "Muted" : `${Math.round(100 * level)} %`);
    const path = silent ? MUTED : level > 0.5 ? LOUD : QUIET;
    if (path === shown) return;
    shown = path;
    const label = silent ? "Sound on" : "Mute";
    mute.replaceChildren(icon(path));
    mute.setAttribute("aria-label", label);
    mute.title = `${label} (M)`;
  };
  mute.addEventListener("click", () => toggleMuted(player));
  volume.addEventListener("input", () => {
    player.volume = Number(volume.value);
    player.muted = player.volume === 0;
  });
  player.addEventListener("volumechange", update, { signal: player.disposed });
  update();
  bar.append(element("div", { class: "sound" }, mute, volume));
}
