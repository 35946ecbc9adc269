import { beforeEach, expect, it } from "vitest";
import type { Shot } from "../../src/renderer/shot";
import type { SplatDrawer } from "../../src/renderer/splat_drawer";
import { Outlook } from "../../src/xr/outlook";
import { type Similarity, yawRotation } from "../../src/xr/similarity";
import { fakeCanvas } from "../canvas";

const AT: Similarity = { rotation: yawRotation(0), scale: 1, translation: [0, 0, 0] };
const pose = { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [0, 0, 0] } as const;
const camera = { width: 4, height: 4, fx: 4, fy: 4, cx: 2, cy: 2, near: 0.1 };
const shot: Shot = { pose, camera, time: 0, antialiased: true, rig: [] };

let drawn: (readonly [number, number])[]; // lower left corners of the small pictures
let outlook: Outlook;

beforeEach(() => {
  drawn = [];
  outlook = new Outlook({ up: [0, 1, 0], background: [0, 0, 0], center: [0, 0, -10] }, true);
});

/** A frame with the head at x in the room. */
function frame(now: number, x = 0, scale = 1): boolean {
  const gl = fakeCanvas().getContext("webgl2");
  const splats = { gl, draw: (_: Shot, origin: readonly [number, number]) => drawn.push(origin) };
  const head = { position: [x, 0, 0], rotation: yawRotation(0) } as const;
  return outlook.update(now, head, { ...AT, scale }, shot, splats as unknown as SplatDrawer);
}

it("waits for an order of what is all round, and then draws one of six small pictures a frame", () => {
  for (const now of [0, 100, 400]) frame(now);
  expect(drawn).toEqual([]);
  for (let i = 0; i < 20; i++) frame(600 + i);
  expect(drawn).toEqual([0, 1, 2, 3, 4, 5].map((face) => [24 * face, 0]));
});

it("draws them again where the head has gone far, or the scene has another size", () => {
  const look = (x: number, scale: number) => {
    for (let i = 0; i < 8; i++) frame(600 + i, x, scale);
    return drawn.splice(0).length;
  };
  frame(0);
  expect(look(0, 1)).toBe(6);
  expect(look(0.9, 1)).toBe(0);
  expect(look(1.1, 1)).toBe(6);
  expect(look(1.1, 1.5)).toBe(6);
});

it("begins anew when the context has come back, and waits for an order again", () => {
  for (const now of [0, 600, 610]) frame(now);
  expect(drawn.splice(0)).toHaveLength(2);
  outlook.attach(fakeCanvas().getContext("webgl2") as WebGL2RenderingContext);
  for (const now of [700, 1100]) frame(now);
  expect(drawn).toEqual([]);
  for (let i = 0; i < 8; i++) frame(1300 + i);
  expect(drawn).toHaveLength(6);
});

it("tells who sees nothing of the scene, once that is known", () => {
  frame(0);
  expect(frame(5000)).toBe(false);
  for (let i = 1; i < 7; i++) frame(5000 + i);
  expect(frame(6100)).toBe(true);
});
