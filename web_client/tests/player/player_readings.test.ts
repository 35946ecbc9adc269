import { expect, it, vi } from "vitest";
import { asked } from "../../src/player/media_api";
import type { MountedScene } from "../../src/player/mounted_scene";
import { PlayerReadings } from "../../src/player/player_readings";

const PIXELS = { width: 1, height: 1 };

class Player extends PlayerReadings {
  protected asked = asked({});
  protected changed = vi.fn();
  protected emit = vi.fn();
  protected settled = async () => true;

  constructor(protected mounted: MountedScene | null) {
    super();
  }
}

it("has nothing to show or to read without a scene", () => {
  const player = new Player(null);
  const { manifest, width, height, scene, statistics } = player;
  expect([manifest, width, height, scene, statistics]).toEqual([null, 0, 0, null, null]);
  expect(() => player.readPixels()).toThrow("nothing has been drawn yet");
});

it("reads the scene that is there", () => {
  const readPixels = vi.fn(() => PIXELS);
  const stats = { splats: 3 };
  const shown = { manifest: { end: 2 }, canvas: { width: 8, height: 6 }, player: { stats, readPixels } };
  const player = new Player(shown as unknown as MountedScene);
  const { manifest, width, height, scene, statistics } = player;
  expect([manifest, width, height, scene, statistics]).toEqual([{ end: 2 }, 8, 6, shown.player, stats]);
  expect(player.readPixels()).toEqual(PIXELS);
});
