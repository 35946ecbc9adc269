/** Buttons for the scene in a headset or in the room, each visible only if the browser and a device offer it. */

import { element, setAttribute, setText } from "../dom/element";
import { adoptStyle } from "../dom/shadow_style";
import type { HgsPlayer } from "../player/hgs_player";
import { type HeadsetMode, offeredModes } from "../xr/offer";
import { describeRefusal, requestSession } from "../xr/session_request";
import css from "./headset_buttons.css?inline";

const WORDS: Readonly<Record<HeadsetMode, readonly [string, string]>> = {
  "immersive-vr": ["VR", "Show in the headset"],
  "immersive-ar": ["AR", "Show in this room"],
};

const LEAVE = "Leave the headset";

export class HeadsetButtons {
  readonly #buttons = new Map<HeadsetMode, HTMLButtonElement>();
  readonly #refusal = element("p", { class: "headset-refusal", role: "alert", hidden: true });
  readonly node: HTMLElement;
  #session: XRSession | null = null;
  #asking = false;

  constructor(
    readonly player: HgsPlayer,
    shadow: ShadowRoot,
  ) {
    adoptStyle(shadow, css);
    const signal = player.disposed;
    for (const [mode, [text, label]] of Object.entries(WORDS) as [HeadsetMode, readonly [string, string]][]) {
      const onclick = () => void this.#press(mode);
      const attributes = { type: "button", class: "round headset", hidden: true, title: label, onclick };
      this.#buttons.set(mode, element("button", { ...attributes, "aria-label": label }, text));
    }
    this.node = element("div", { class: "headset-buttons" }, ...this.#buttons.values(), this.#refusal);
    const { xr } = navigator;
    void this.#offer(xr);
    xr?.addEventListener("devicechange", () => void this.#offer(xr), { signal });
    signal.addEventListener("abort", () => void this.#session?.end().catch(() => {}));
  }

  async #offer(xr: XRSystem | undefined): Promise<void> {
    const modes = await offeredModes(xr);
    for (const [mode, button] of this.#buttons) button.hidden = !modes.includes(mode);
  }

  /** Enter, or leave if the scene is in the headset already. */
  async #press(mode: HeadsetMode): Promise<void> {
    const { xr } = navigator;
    if (this.#session)
      await this.#session.end().catch(() => {}); // it may be over already
    else if (xr && !this.#asking) await this.#enter(xr, mode);
  }

  async #enter(xr: XRSystem, mode: HeadsetMode): Promise<void> {
    this.#asking = true;
    this.#refusal.hidden = true;
    try {
      const session = await requestSession(xr, mode);
      session.addEventListener("end", () => this.#present(null));
      this.#present(session);
      const { HeadsetSession } = await import("../xr/headset_session"); // only for visitors with a headset
      await HeadsetSession.begin(session, this.player);
    } catch (error) {
      await this.#session?.end().catch(() => {}); // it may be over already
      // biome-ignore lint/suspicious/noConsole: the page has plain words for it; this is the cause
      console.warn(error);
      this.#refusal.hidden = false;
      setText(this.#refusal, describeRefusal(error));
    } finally {
      this.#asking = false;
    }
  }

  #present(session: XRSession | null): void {
    this.#session = session;
    for (const [mode, button] of this.#buttons) {
      const label = session ? LEAVE : WORDS[mode][1];
      setAttribute(button, "aria-label", label);
      setAttribute(button, "title", label);
    }
  }
}
