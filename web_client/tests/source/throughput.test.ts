import { expect, it } from "vitest";
import { Throughput } from "../../src/source/throughput";

it("adds up what comes side by side", () => {
  const throughput = new Throughput();
  throughput.arrived(1000, 0, 500);
  throughput.arrived(1000, 0, 1000);
  expect(throughput.bytesPerSecond).toBe(2000);
});

it("forgets how the line once was", () => {
  const throughput = new Throughput();
  throughput.arrived(1e6, 0, 1);
  for (let i = 0; i < 8; i++) throughput.arrived(100, 1000 * i, 1000 * (i + 1));
  expect(throughput.bytesPerSecond).toBe(100);
});

it("has a guess to begin with", () => {
  expect(new Throughput().bytesPerSecond).toBeGreaterThan(0);
});
