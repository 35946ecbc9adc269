import { readFileSync } from "node:fs";
import { describe, expect, it, vi } from "vitest";
import type { HgsPlayer } from "../../src/player/hgs_player";
import { FLYING, GESTURES, shownKeys } from "../../src/ui/help";
import { playerKeys } from "../../src/ui/key_bindings";
import { mayBeObeyed } from "../../src/ui/key_listener";
import type { PlayerActions } from "../../src/ui/player_actions";

const camera = { turn: vi.fn(), lookAround: vi.fn(), zoom: vi.fn(), release: vi.fn() };
const player = { camera, duration: 20, playbackRate: 1 } as unknown as HgsPlayer;

function keys(more: Partial<PlayerActions> = {}, flying = false) {
  const surroundings = { fly: { active: flying }, link: () => "" };
  const actions = { surroundings, moves: true, seekBy: vi.fn(), jump: vi.fn(), ...more } as unknown as PlayerActions;
  const view = { toggleStatistics: vi.fn(), toggleFullscreen: vi.fn(), toggleHelp: vi.fn() };
  const groups = playerKeys(player, actions, view);
  const bindings = groups.flatMap((group) => group.bindings);
  const press = (key: string) => bindings.find((binding) => binding.keys.includes(key))?.action(key);
  return { actions, groups, bindings, press };
}

it("gives every key to one action", () => {
  const all = keys().bindings.flatMap((binding) => binding.keys);
  expect(new Set(all).size).toBe(all.length);
});

it("has no key that the player would not wait for", () => {
  for (const key of keys().bindings.flatMap((binding) => binding.keys)) {
    expect(mayBeObeyed({ key: key.replace("Shift+", "") } as KeyboardEvent), key).toBe(true);
  }
});

it("seeks with arrows and jumps with digits", () => {
  const { actions, press } = keys();
  press("ArrowRight");
  expect(actions.seekBy).toHaveBeenLastCalledWith(2);
  press("j");
  expect(actions.seekBy).toHaveBeenLastCalledWith(-4);
  press("7");
  expect(actions.jump).toHaveBeenLastCalledWith(0.7);
});

it("turns the camera with arrows where nothing moves, and lets go of it", () => {
  const { actions, press } = keys({ moves: false } as Partial<PlayerActions>);
  press("ArrowLeft");
  expect(actions.seekBy).not.toHaveBeenCalled();
  expect(camera.turn).toHaveBeenCalledOnce();
  expect(camera.turn.mock.calls[0][0]).toBeGreaterThan(0);
  expect(camera.release).toHaveBeenCalled();
});

it("looks around with arrows while flying", () => {
  keys({}, true).press("Shift+ArrowLeft");
  expect(camera.lookAround).toHaveBeenCalledOnce();
  expect(camera.lookAround.mock.calls[0][0]).toBeGreaterThan(0); // to the left
});

describe("docs/viewer.md", () => {
  const text = readFileSync(new URL("../../../docs/viewer.md", import.meta.url), "utf8");
  const rows = new Set([...text.matchAll(/^\| (.*?) \| (.*?) \|$/gm)].map(([, shown, does]) => `${shown}: ${does}`));

  it.each([...keys().bindings.map((binding) => [shownKeys(binding), binding.does] as const), ...FLYING, ...GESTURES])(
    "has a row for %s: %s",
    (shown, does) => {
      const written = shown.split(", ").map((key) => `\`${key}\``);
      expect([...rows]).toContain(`${written.join(", ")}: ${does}`);
    },
  );
});
