import { describe, expect, it } from "vitest";
import { PlayerClock } from "../../src/scene/clock";

const always = () => true;

describe("PlayerClock", () => {
  it("stands at the start until it plays", () => {
    const clock = new PlayerClock(2, 5);
    clock.tick(0, always);
    expect(clock.tick(1, always)).toBe(2);
  });

  it("follows the time that it is told, at its rate", () => {
    const clock = new PlayerClock(0, 10);
    clock.rate = 2;
    clock.play();
    clock.tick(100, always);
    expect(clock.tick(100.1, always)).toBeCloseTo(0.2);
  });

  it("does not count the time it was paused", () => {
    const clock = new PlayerClock(0, 10);
    clock.play();
    clock.tick(0, always);
    clock.tick(0.1, always);
    clock.pause();
    clock.tick(5, always);
    clock.play();
    clock.tick(9, always);
    expect(clock.tick(9.1, always)).toBeCloseTo(0.2);
  });

  it("waits just before the edge of a scene that grows, and goes on when there is more", () => {
    const clock = new PlayerClock(0, 1);
    clock.grows = true;
    clock.play();
    clock.seek(5);
    expect(clock.time).toBe(clock.last);
    clock.tick(0, always);
    clock.tick(0.2, always);
    expect([clock.time, clock.stalled, clock.playing]).toEqual([clock.last, true, true]);
    expect(clock.last).toBeLessThan(1);
    clock.end = 2;
    clock.tick(0.3, always);
    expect([clock.time > 1, clock.stalled]).toEqual([true, false]);
    clock.grows = false;
    clock.loop = false;
    clock.seek(1.95);
    clock.tick(0.4, always);
    clock.tick(0.6, always);
    expect([clock.time, clock.stalled, clock.playing]).toEqual([2, false, false]);
  });

  it("loops without losing the rest of the step", () => {
    const clock = new PlayerClock(1, 2);
    clock.play();
    clock.seek(1.9);
    clock.tick(0, always);
    expect(clock.tick(0.2, always)).toBeCloseTo(1.1);
    expect(clock.playing).toBe(true);
  });

  it("stops at the end without a loop, and plays again from the start", () => {
    const clock = new PlayerClock(0, 1);
    clock.loop = false;
    clock.play();
    clock.seek(0.9);
    clock.tick(0, always);
    expect(clock.tick(0.2, always)).toBe(1);
    expect(clock.playing).toBe(false);
    clock.play();
    expect(clock.time).toBe(0);
  });

  it("clamps a seek to the scene", () => {
    const clock = new PlayerClock(1, 2);
    clock.seek(-5);
    expect(clock.time).toBe(1);
    clock.seek(9);
    expect(clock.time).toBe(2);
  });

  it("stalls before data that is missing and starts anew without a jump", () => {
    const clock = new PlayerClock(0, 10);
    clock.play();
    clock.tick(0, always);
    const before = clock.tick(0.1, always);
    expect(clock.tick(0.2, (time) => time < 0.15)).toBe(before);
    expect(clock.stalled).toBe(true);
    clock.tick(0.3, () => false);
    expect(clock.tick(0.4, always)).toBeCloseTo(before + 0.1);
    expect(clock.stalled).toBe(false);
  });

  it("goes on where it was after a hidden tab", () => {
    const clock = new PlayerClock(0, 100);
    clock.play();
    clock.tick(0, always);
    expect(clock.tick(60, always)).toBeLessThan(0.3);
  });

  it("stands in a scene of no length", () => {
    const clock = new PlayerClock(3, 3);
    clock.play();
    clock.tick(0, always);
    expect(clock.tick(1, always)).toBe(3);
    expect(clock.playing).toBe(false);
  });

  it.each([0, -1, 17, Number.NaN])("refuses the rate %s", (rate) => {
    const clock = new PlayerClock(0, 1);
    expect(() => {
      clock.rate = rate;
    }).toThrow(RangeError);
  });

  it("repeats a stretch, at any rate and whether or not it loops", () => {
    const clock = new PlayerClock(0, 10);
    clock.loop = false;
    clock.range = [2, 3];
    clock.seek(2.9);
    clock.play();
    clock.tick(0, always);
    expect(clock.tick(0.2, always)).toBeCloseTo(2.1);
    expect(clock.after(2.5)).toBeCloseTo(2.6);
    expect(clock.playing).toBe(true);
  });

  it("plays into a stretch from before it, and on from behind it", () => {
    const clock = new PlayerClock(0, 10);
    clock.range = [2, 3];
    clock.seek(1.9);
    expect(clock.after(0.2)).toBeCloseTo(2.1);
    clock.seek(5);
    expect(clock.after(1)).toBeCloseTo(6);
    clock.play(); // by hand: that begins the stretch anew
    expect(clock.time).toBe(2);
  });
});
