import { describe, expect, it } from "vitest";
import { CreditWindow } from "../../src/protocol/credit_window";

const KIB = 1 << 10;

/**
 * A line that carries `rate` bytes per ms over `trip` ms there and back: the server sends all that it may, and what is
 * more than the line carries waits in a queue. Returns the window after `seconds`, and the bytes that came.
 */
function play(rate: number, trip: number, seconds: number, welcome = 10_000): { window: CreditWindow; bytes: number } {
  const window = new CreditWindow(2 * trip, 0); // TCP and the upgrade
  window.answered(trip + welcome / rate);
  const arrivals: { at: number; bytes: number; ping: boolean }[] = [];
  let free = 0; // when the line is
  let bytes = 0;
  const put = (at: number, size: number, ping: boolean) => {
    free = Math.max(free, at + trip / 2) + size / rate;
    arrivals.push({ at: free + trip / 2, bytes: size, ping });
  };
  /** What is granted at `now` is sent half a trip later, in frames. */
  const grant = (now: number) => {
    for (let left = window.grant(); left > 0; left -= 16 * KIB) put(now, Math.min(left, 16 * KIB), false);
  };
  grant(0);
  for (let next = arrivals.shift(); next && next.at < 1000 * seconds; next = arrivals.shift()) {
    if (next.ping) {
      window.answered(next.at);
      continue;
    }
    bytes += next.bytes;
    if (window.received(next.bytes, next.at)) put(next.at, 0, true);
    grant(next.at);
  }
  return { window, bytes };
}

describe("CreditWindow", () => {
  it("begins with what does not make a slow line late", () => {
    const window = new CreditWindow(80, 0);
    expect(window.grant()).toBe(64 * KIB);
    expect(window.grant()).toBe(0);
  });

  it("grants in portions of a quarter", () => {
    const window = new CreditWindow(80, 0);
    window.grant();
    window.answered(1000); // behind other data: the line is full
    window.received(10 * KIB, 1000);
    expect(window.grant()).toBe(0);
    window.received(6 * KIB, 1001);
    expect(window.grant()).toBe(16 * KIB);
  });

  it("stays small on a slow line, where pings wait behind the window", () => {
    const { window, bytes } = play(250, 40, 30); // 2 Mbit/s
    expect(window.size).toBe(64 * KIB);
    expect(bytes / (250 * 30_000)).toBeGreaterThan(0.98);
  });

  it.each([
    [6250, 40], // 50 Mbit/s
    [1250, 100], // 10 Mbit/s
    [12_500, 3], // 100 Mbit/s next door
  ])("grows to twice what a line of %s bytes/ms holds in %s ms", (rate, trip) => {
    const held = rate * Math.max(trip, 50);
    const { window, bytes } = play(rate, trip, 10);
    expect(window.size).toBeGreaterThan(1.5 * held);
    expect(window.size).toBeLessThan(2.6 * held);
    expect(bytes / (rate * 10_000)).toBeGreaterThan(0.95);
  });

  it("doubles with every round trip until something waits on the line", () => {
    expect(play(6250, 40, 0.13).window.size).toBeGreaterThan(6250 * 40);
    expect(play(125_000, 300, 2).window.size).toBe(2 << 20);
  });

  it("is never more than twice the smallest on a slow line", () => {
    for (let seconds = 0.1; seconds < 5; seconds += 0.1) {
      expect(play(250, 40, seconds).window.size).toBeLessThanOrEqual(128 * KIB);
    }
  });

  it("never has more than 2 MiB in flight", () => {
    expect(play(125_000, 300, 20).window.size).toBe(2 << 20);
  });

  it("becomes small again on a line that has become slow", () => {
    const window = new CreditWindow(80, 0);
    window.answered(40);
    window.grant();
    let now = 0;
    const run = (rate: number, seconds: number) => {
      for (const end = now + 1000 * seconds; now < end; now += 10) {
        if (window.received(10 * rate, now)) window.answered(now + 40);
        window.grant();
      }
    };
    run(6250, 1);
    expect(window.size).toBeGreaterThan(256 * KIB);
    run(250, 2);
    expect(window.size).toBe(64 * KIB);
  });

  it("is not made large by a burst of what the page was too busy to take", () => {
    const window = new CreditWindow(10, 0);
    window.answered(5);
    window.grant();
    for (let second = 0; second < 20; second++) {
      const now = 1000 * second;
      for (let k = 0; k < 4; k++) if (window.received(16 * KIB, now + k)) window.answered(now + 5);
      if (window.received(1 * KIB, now + 110)) window.answered(now + 115);
      window.grant();
    }
    expect(window.size).toBe(64 * KIB);
  });
});
