import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { HgsPlayer } from "../../src/player/hgs_player";
import { pauseOutOfSight } from "../../src/ui/out_of_sight";

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
