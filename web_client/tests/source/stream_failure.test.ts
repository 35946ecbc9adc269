import { describe, expect, it } from "vitest";
import { streamFailure } from "../../src/source/stream_failure";

describe("a stream's failure", () => {
  it.each(["scene-not-found", 4004])("%s: the scene is not there", (code) => {
    expect(streamFailure(code)).toBe("no-scene");
  });

  it.each(["protocol-unsupported", 4001, "malformed", 4000])("%s: page and server differ", (code) => {
    expect(streamFailure(code)).toBe("not-understood");
  });

  it.each(["credit-overflow", 4009, 1009, "a code of tomorrow"])("%s: it has ended", (code) => {
    expect(streamFailure(code)).toBe("ended");
  });
});
