import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { HgsPlayer } from "../../src/player/hgs_player";
import { pauseOutOfSight, stepFrames, togglePlaying } from "../../src/ui/playing";

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

let see: (seen: boolean) => void;
let disconnected: boolean;
const dispose = new AbortController();
const player = { paused: false, disposed: dispose.signal, play: () => {}, pause: () => {} };

beforeEach(() => {
  disconnected = false;
  vi.stubGlobal("IntersectionObserver", function observe(this: object, tell: (entries: object[]) => void) {
    see = (seen) => tell([{ isIntersecting: !seen }, { isIntersecting: seen }]); // the last one counts
    Object.assign(this, {
      observe: () => {},
      disconnect: () => {
        disconnected = true;
      },
    });
  });
  player.paused = false;
  player.play = () => {
    player.paused = false;
  };
  player.pause = () => {
    player.paused = true;
  };
  pauseOutOfSight({} as HTMLElement, player as unknown as HgsPlayer);
});
afterEach(() => vi.unstubAllGlobals());

it("pauses out of sight and goes on in sight", () => {
  see(false);
  expect(player.paused).toBe(true);
  see(true);
  expect(player.paused).toBe(false);
});

it("leaves a player alone that stood before", () => {
  player.pause();
  see(false);
  see(true);
  expect(player.paused).toBe(true);
});

it("lets go with the player", () => {
  dispose.abort();
  expect(disconnected).toBe(true);
});
