import { expect, it } from "vitest";
import { Stillness } from "../../src/player/picture";
import type { View } from "../../src/scene/view";

const view = (x: number): View => ({
  pose: { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [x, 0, 0] },
  camera: { width: 8, height: 8, fx: 8, fy: 8, cx: 4, cy: 4, near: 0.01 },
});

it("is still from the first picture of a standing scene", () => {
  expect(new Stillness().update(view(0), false, 0)).toBe(true);
});

it("is still a moment after the view has stopped", () => {
  const stillness = new Stillness();
  stillness.update(view(0), false, 0);
  expect(stillness.update(view(1), false, 1000)).toBe(false);
  expect(stillness.update(view(1), false, 1100)).toBe(false);
  expect(stillness.update(view(1), false, 1200)).toBe(true);
});

it("is never still while the scene moves", () => {
  const stillness = new Stillness();
  stillness.update(view(0), true, 0);
  expect(stillness.update(view(0), true, 9000)).toBe(false);
  expect(stillness.update(view(0), false, 9100)).toBe(false);
  expect(stillness.update(view(0), false, 9200)).toBe(true);
});
