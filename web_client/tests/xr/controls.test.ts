import { expect, it, vi } from "vitest";
import { Controls } from "../../src/xr/controls";
import type { Panel } from "../../src/xr/panel";
import type { Control } from "../../src/xr/panel_layout";

const COMMANDS = { play: "togglePlay", mute: "toggleMuted", reset: "reset", leave: "leave" } as const;

/** Press what the panel has under the hand. */
function press(control: Control) {
  const session = new EventTarget();
  const panel = { pointed: () => ({ control, x: 0, y: 0, distance: 1 }), wake: () => {} };
  const names = ["togglePlay", "toggleMuted", "scrub", "seek", "turn", "reset", "leave"] as const;
  const [togglePlay, toggleMuted, scrub, seek, turn, reset, leave] = names.map(() => vi.fn());
  const commands = { togglePlay, toggleMuted, scrub, seek, turn, reset, leave };
  new Controls(session as XRSession, {} as XRReferenceSpace, panel as unknown as Panel, commands);
  const transform = { position: { x: 0, y: 0, z: 0 }, orientation: { x: 0, y: 0, z: 0, w: 1 } };
  const frame = { getPose: () => ({ transform }) };
  session.dispatchEvent(Object.assign(new Event("selectstart"), { inputSource: {}, frame }));
  return names.filter((name) => commands[name].mock.calls.length > 0);
}

it.each(Object.keys(COMMANDS) as (keyof typeof COMMANDS)[])("the panel's %s does what it says", (control) => {
  expect(press(control)).toEqual([COMMANDS[control]]);
});
