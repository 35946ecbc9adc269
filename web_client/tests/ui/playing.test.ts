import { expect, it, vi } from "vitest";
import type { HgsPlayer } from "../../src/player/hgs_player";
import { stepFrames, togglePlaying } from "../../src/ui/playing";

const scene = (more: Partial<HgsPlayer>) => {
  const player = { duration: 2, paused: true, play: vi.fn(), pause: vi.fn(), currentTime: 1, ...more };
  return player as unknown as HgsPlayer & typeof player;
};

it("plays what stands, and the other way round", () => {
  const [standing, playing] = [scene({}), scene({ paused: false })];
  togglePlaying(standing);
  expect(standing.play).toHaveBeenCalledOnce();
  togglePlaying(playing);
  expect(playing.pause).toHaveBeenCalledOnce();
});

it("plays nothing in which nothing moves", () => {
  const still = scene({ duration: 0 });
  togglePlaying(still);
  expect(still.play).not.toHaveBeenCalled();
});

it("stands still so many frames later", () => {
  const player = scene({ manifest: { frameRate: 10 } as HgsPlayer["manifest"] });
  stepFrames(player, -2);
  expect(player.pause).toHaveBeenCalledOnce();
  expect(player.currentTime).toBeCloseTo(0.8);
});
