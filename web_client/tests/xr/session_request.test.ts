import { expect, it } from "vitest";
import { describeRefusal } from "../../src/xr/session_request";

it("tells a refusal by what the reader can do about it", () => {
  const words = ["NotAllowedError", "NotSupportedError", "InvalidStateError", "AbortError"].map((name) =>
    describeRefusal(new DOMException("", name)),
  );
  expect(new Set(words).size).toBe(4);
  expect(describeRefusal(new Error("other"))).toBe(words[3]);
});
