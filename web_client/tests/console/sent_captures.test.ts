import { expect, it } from "vitest";
import { describeUpload } from "../../src/console/sent_captures";

const upload = {
  id: "a",
  name: "a",
  state: "receiving",
  files: 1,
  bytes: 2e9,
  received: 8e8,
  expires: 200_000,
  capture: null,
} as const;

it("says how far an upload is, and how long it is kept", () => {
  expect(describeUpload(upload, 27_000)).toBe("40 % of 2.0 GB has arrived; choose the same folder within 48 h");
  expect(describeUpload({ ...upload, state: "finished", capture: "/a" }, 0)).toBe("2.0 GB");
});
