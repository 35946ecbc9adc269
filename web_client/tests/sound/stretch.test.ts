import { describe, expect, it } from "vitest";
import { stretched } from "../../src/sound/stretch";

const RATE = 48_000;
const LEAD = 5760; // samples before what counts

/** A tone over seconds `from` to `until`, with what lies before. */
function tone(from: number, until: number, frequency = 330): Float32Array {
  const first = Math.round(from * RATE) - LEAD;
  return Float32Array.from({ length: Math.round(until * RATE) - first }, (_, i) =>
    Math.sin((2 * Math.PI * frequency * (first + i)) / RATE),
  );
}

/** Periods per second, by upward crossings of zero. */
function pitch(samples: Float32Array): number {
  let crossings = 0;
  for (let i = 1; i < samples.length; i++) if (samples[i - 1] < 0 && samples[i] >= 0) crossings++;
  return (crossings * RATE) / samples.length;
}

describe("stretched", () => {
  it.each([0.25, 0.5, 0.75, 1.5, 2, 4])("keeps the pitch and takes another time at rate %d", (rate) => {
    const [made] = stretched([tone(0, 1)], LEAD, rate, RATE);
    expect(made.length).toBe(Math.round(RATE / rate));
    expect(Math.abs(pitch(made) - 330)).toBeLessThan(8);
    expect(made.reduce((most, sample) => Math.max(most, sample))).toBeGreaterThan(0.9);
  });

  it.each([0.5, 1.5, 2])("joins with the next piece at rate %d", (rate) => {
    const [a] = stretched([tone(1, 2)], LEAD, rate, RATE);
    const [b] = stretched([tone(2, 3)], LEAD, rate, RATE);
    const steps = Math.max(
      ...[a, b].map((x) => x.slice(1).reduce((most, s, i) => Math.max(most, Math.abs(s - x[i])), 0)),
    );
    expect(Math.abs(b[0] - a[a.length - 1])).toBeLessThan(2 * steps);
  });

  it.each([0.5, 2])("puts a click within 20 ms of its time at rate %d", (rate) => {
    const samples = new Float32Array(LEAD + RATE);
    for (let i = 0; i < 100; i++) samples[LEAD + 24_000 + i] = Math.sin(i) * Math.exp(-i / 30);
    const [made] = stretched([samples, samples.slice()], LEAD, rate, RATE);
    const loudest = made.reduce((at, s, i) => (Math.abs(s) > Math.abs(made[at]) ? i : at), 0);
    expect(Math.abs(loudest / RATE - 0.5 / rate)).toBeLessThan(0.02);
  });
});
