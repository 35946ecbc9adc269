import { afterAll, beforeAll, expect, it, vi } from "vitest";
import { Viewpoint } from "../../src/player/viewpoint";
import type { CanvasRenderer } from "../../src/renderer/canvas_renderer";
import { manifest } from "../scene";

beforeAll(() => void vi.stubGlobal("cancelAnimationFrame", () => {}));
afterAll(() => void vi.unstubAllGlobals());

/** From a camera 4 units before the middle of a scene. */
function viewpoint(near: number, exact = false): Viewpoint {
  const canvas = { style: {} } as HTMLCanvasElement;
  const options = { camera: null, exact, size: { width: 8, height: 8 } };
  const scene = () => ({ renderer: {} as CanvasRenderer, shot: null });
  const events = { changed: () => {}, scene };
  const made = new Viewpoint(canvas, options, events, new AbortController().signal);
  const ahead = [
    [1, 0, 0, 0],
    [0, 1, 0, 0],
    [0, 0, 1, 4],
    [0, 0, 0, 1],
  ];
  const camera = { name: "a", width: 8, height: 8, fx: 8, fy: 8, cx: 4, cy: 4, near, worldToCamera: ahead };
  made.begin(manifest({ cameras: [camera] }));
  return made;
}

it("fades what is nearer than a share of the way to what it turns about", () => {
  const moved = viewpoint(0.01);
  expect(moved.view()?.clear).toBeCloseTo(0.6);
  moved.place({ position: [0, 0, -2], target: [0, 0, 0], up: [0, -1, 0] });
  expect(moved.view()?.clear).toBeCloseTo(0.3);
});

it("fades towards a near plane that is farther than that, and comes along", () => {
  const moved = viewpoint(1);
  expect(moved.view()?.clear).toBeCloseTo(1.5);
  moved.place({ position: [0, 0, -2], target: [0, 0, 0], up: [0, -1, 0] });
  expect(moved.view()?.clear).toBeCloseTo(0.75);
});

it("fades nothing in an exact picture", () => {
  expect(viewpoint(1, true).view()?.clear).toBeUndefined();
  expect(viewpoint(1, true).view()?.still).toBe(1);
});
