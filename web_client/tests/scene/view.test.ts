import { expect, it } from "vitest";
import { sameView, type View } from "../../src/scene/view";

const view: View = {
  pose: { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [0, 0, 0] },
  camera: { width: 8, height: 8, fx: 8, fy: 8, cx: 4, cy: 4, near: 0.01 },
  clear: 1,
};

it("is the same from the same place", () => {
  expect(sameView(view, structuredClone(view))).toBe(true);
});

it("is another where other things fade, or from elsewhere", () => {
  expect(sameView(view, { ...view, clear: 2 })).toBe(false);
  expect(sameView(view, { ...view, pose: { ...view.pose, translation: [0, 0, 1] } })).toBe(false);
});
