import { beforeEach, describe, expect, it, vi } from "vitest";
import { Picture } from "../../src/player/picture";
import type { CanvasRenderer } from "../../src/renderer/canvas_renderer";
import type { Shot } from "../../src/renderer/shot";

const shot = (x: number, time = 0): Shot => ({
  pose: { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [x, 0, 0] },
  camera: { width: 8, height: 8, fx: 8, fy: 8, cx: 4, cy: 4, near: 0.01 },
  time,
  antialiased: false,
  rig: [],
});

let device: { busy: boolean; moving: number; lost: boolean };
let draw: ReturnType<typeof vi.fn>;
let picture: Picture;

beforeEach(() => {
  device = { busy: false, moving: 0, lost: false };
  draw = vi.fn(() => {
    device.busy = true;
  });
  const renderer = {
    draw,
    busy: () => device.busy,
    quality: {
      resting: 0,
      get moving() {
        return device.moving;
      },
    },
    get lost() {
      return device.lost;
    },
  };
  picture = new Picture(renderer as unknown as CanvasRenderer, { pictured: true });
});

describe("Picture", () => {
  it("asks for frames until the device is done, and then for none", () => {
    expect(picture.update(shot(0), false, 0)).toBe(true);
    device.busy = false;
    expect(picture.update(shot(0), false, 16)).toBe(false);
    expect(picture.update(shot(0), false, 32)).toBe(false);
    expect(draw).toHaveBeenCalledOnce();
  });

  it("draws again what is out of date, once the device is done", () => {
    picture.update(shot(0), false, 0);
    picture.outdate();
    picture.update(shot(0), false, 16);
    expect(draw).toHaveBeenCalledOnce();
    device.busy = false;
    picture.update(shot(0), false, 32);
    expect(draw).toHaveBeenCalledTimes(2);
  });

  it("draws again at another time of the scene", () => {
    for (const [time, now] of [
      [0, 0],
      [0.1, 16],
      [0.1, 32],
    ]) {
      picture.update(shot(0, time), true, now);
      device.busy = false;
    }
    expect(draw).toHaveBeenCalledTimes(2);
  });

  it("asks a slow device for frames until a view that has moved is drawn finely", () => {
    device.moving = 3;
    picture.update(shot(0), false, 0);
    device.busy = false;
    expect(picture.update(shot(1), false, 1000)).toBe(true);
    device.busy = false;
    expect(picture.update(shot(1), false, 1100)).toBe(true);
    expect(picture.shows(shot(1), false)).toBe(false);
    picture.update(shot(1), false, 1200);
    device.busy = false;
    expect(picture.update(shot(1), false, 1216)).toBe(false);
    expect(draw.mock.calls.map(([, rung]) => rung)).toEqual([0, 3, 0]);
    expect(picture.shows(shot(1), false)).toBe(true);
  });

  it("counts what a playing scene does not get drawn", () => {
    picture.update(shot(0), true, 0);
    picture.outdate();
    picture.update(shot(0), true, 16);
    expect([picture.frames.drawn, picture.frames.dropped]).toEqual([1, 1]);
  });

  it("draws nothing and asks for nothing while the context is lost", () => {
    device.lost = true;
    expect(picture.update(shot(0), false, 0)).toBe(false);
    expect(picture.shows(shot(0), false)).toBe(false);
    device.lost = false;
    picture.update(shot(0), false, 16);
    expect(draw).toHaveBeenCalledOnce();
  });
});
