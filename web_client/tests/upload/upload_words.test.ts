import { expect, it } from "vitest";
import { describeRest, describeTransfer } from "../../src/upload/upload_words";

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
