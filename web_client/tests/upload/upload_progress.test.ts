import { expect, it } from "vitest";
import { describeRest, describeTransfer, Speed } from "../../src/upload/upload_progress";

it.each([
  [1000, null, ""],
  [59_000, 1000, "less than a minute left"],
  [240_000, 1000, "about 4 min left"],
  [36_000_000, 1000, "about 10 h left"],
])("the rest of %d bytes at %d a second", (bytes, speed, words) => {
  expect(describeRest(bytes, speed)).toBe(words);
});

const transfer = { state: "sending", reading: false, sent: 5e8, total: 2e9, problem: "" } as const;

it.each([
  [transfer, null, "500 MB of 2.0 GB"],
  [transfer, 5e6, "500 MB of 2.0 GB · 5.0 MB/s · about 5 min left"],
  [{ ...transfer, reading: true }, null, "Reading the files · 500 MB of 2.0 GB"],
  [{ ...transfer, state: "paused" } as const, null, "Paused · 500 MB of 2.0 GB"],
  [
    { ...transfer, state: "waiting", problem: "The server cannot be reached." } as const,
    null,
    "Waiting to try again: The server cannot be reached. · 500 MB of 2.0 GB",
  ],
  [
    {
      ...transfer,
      state: "failed",
      problem: "The server answered 413: one upload may have 1.0 GB; send less",
    } as const,
    null,
    "One upload may have 1.0 GB; send less",
  ],
])("%#", (shown, speed, words) => {
  expect(describeTransfer(shown, speed)).toBe(words);
});

it("says nothing before it knows, and then what the last seconds say", () => {
  const speed = new Speed();
  for (let time = 0; time < 2; time++) speed.note(100 * time, time);
  expect(speed.perSecond()).toBeNull();
  for (let time = 2; time <= 60; time++) speed.note(100 * time, time);
  for (let time = 61; time <= 90; time++) speed.note(6000 + 10 * (time - 60), time);
  expect(speed.perSecond()).toBeCloseTo(10);
  speed.reset();
  expect(speed.perSecond()).toBeNull();
});

it("knows no speed while nothing goes", () => {
  const speed = new Speed();
  for (let time = 0; time < 30; time++) speed.note(5, time);
  expect(speed.perSecond()).toBeNull();
});
