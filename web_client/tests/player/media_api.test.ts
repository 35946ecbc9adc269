import { beforeEach, expect, it, vi } from "vitest";
import type { Manifest } from "../../src/codec/types";
import { asked, MediaApi, withMembers } from "../../src/player/media_api";
import { PlayerClock } from "../../src/scene/clock";
import type { Playback } from "../../src/scene/playback";

class Host {
  readonly kind = "host";
}

const told = vi.fn();
const changed = vi.fn();

class Scene extends withMembers(Host, MediaApi) {
  manifest: Manifest | null = null;
  protected asked = asked({ loop: true, autoplay: true, playbackRate: 2, time: 3 });
  protected playback: Playback | null = null;
  protected changed = changed;
  protected emit = told;
  protected settled = async () => this.playback !== null;

  /** A scene from 1 to 5 seconds has come. */
  arrive(): PlayerClock {
    const clock = new PlayerClock(1, 5);
    const buffer = { ranges: () => [[1, 2]] };
    const play = () => clock.play();
    const setRate = (rate: number) => {
      clock.rate = rate;
    };
    const seek = (time: number) => clock.seek(time);
    this.playback = { clock, buffer, play, pause: () => clock.pause(), setRate, seek } as unknown as Playback;
    this.manifest = { start: 1, end: 5 } as Manifest;
    this.begin();
    return clock;
  }
}

beforeEach(() => vi.clearAllMocks());

it("is what its base is, and a played scene", () => {
  const scene = new Scene();
  expect(scene.kind).toBe("host");
  expect(scene).toBeInstanceOf(Host);
  for (const member of ["play", "seek", "currentTime", "buffered"]) expect(member in scene).toBe(true);
  expect("play" in Host.prototype).toBe(false);
  expect(scene.constructor).not.toBe(MediaApi);
});

it("keeps what it is asked for until the scene is there", () => {
  const scene = new Scene();
  expect([scene.paused, scene.currentTime, scene.start, scene.duration]).toEqual([false, 3, 0, Number.NaN]);
  scene.playbackRate = 0.5;
  scene.currentTime = 2;
  scene.loop = false;
  const clock = scene.arrive();
  expect([clock.playing, clock.rate, clock.time, clock.loop]).toEqual([true, 0.5, 2, false]);
  expect([scene.start, scene.end, scene.duration, scene.buffered]).toEqual([1, 5, 4, [[1, 2]]]);
});

it("stands still if it was paused before it came", () => {
  const scene = new Scene();
  scene.pause();
  expect(scene.arrive().playing).toBe(false);
  expect(scene.paused).toBe(true);
});

it("plays, pauses and ends, and asks for another picture", () => {
  const scene = new Scene();
  const clock = scene.arrive();
  changed.mockClear();
  scene.pause();
  expect([clock.playing, scene.paused, changed.mock.calls.length]).toEqual([false, true, 1]);
  clock.seek(5);
  expect(scene.ended).toBe(true);
  scene.play();
  expect([clock.time, scene.ended]).toEqual([1, false]);
});

it("tells that a sought time is drawn, where there is a scene", async () => {
  const scene = new Scene();
  await scene.seek(2);
  expect(told).not.toHaveBeenCalled();
  scene.arrive();
  await scene.seek(4);
  expect(told).toHaveBeenCalledExactlyOnceWith("seeked", null);
  expect(scene.currentTime).toBe(4);
});

it("refuses times and rates that are none", async () => {
  const scene = new Scene();
  await expect(scene.seek(Number.NaN)).rejects.toThrow("time NaN is not a finite number");
  expect(() => {
    scene.currentTime = Number.POSITIVE_INFINITY;
  }).toThrow(RangeError);
  expect(() => {
    scene.playbackRate = 0;
  }).toThrow(RangeError);
  expect(scene.playbackRate).toBe(2);
});
