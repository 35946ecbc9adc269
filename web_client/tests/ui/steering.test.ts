import { expect, it, vi } from "vitest";
import { steering } from "../../src/ui/steering";

it("turns about the scene, and looks around while flying", () => {
  const camera = { turn: vi.fn(), lookAround: vi.fn(), zoom: vi.fn(), pan: vi.fn(), release: vi.fn(), focus: vi.fn() };
  const fly = { active: false };
  const motion = steering(camera, fly);
  motion.turn(0.1, 0.2);
  expect(camera.turn).toHaveBeenCalledExactlyOnceWith(0.1, 0.2);
  fly.active = true;
  motion.turn(0.3, 0.4);
  expect(camera.turn).toHaveBeenCalledOnce();
  expect(camera.lookAround).toHaveBeenCalledExactlyOnceWith(0.3, 0.4);
});
