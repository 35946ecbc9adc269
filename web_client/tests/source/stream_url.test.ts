import { describe, expect, it } from "vitest";
import { streamUrl } from "../../src/source/open_source";

describe("streamUrl", () => {
  it("is on the page's own server, secure if the page is", () => {
    expect(streamUrl("studio", { protocol: "http:", host: "a:8000" })).toBe("ws://a:8000/v1/scenes/studio/stream");
    expect(streamUrl("studio", { protocol: "https:", host: "a" })).toBe("wss://a/v1/scenes/studio/stream");
  });
});
