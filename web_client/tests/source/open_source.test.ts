import { afterEach, describe, expect, it, vi } from "vitest";
import { openSource } from "../../src/source/open_source";

afterEach(() => vi.unstubAllGlobals());

/** The address of the WebSocket that a source opens. */
async function opened(src: string, base: string): Promise<string> {
  const sockets: string[] = [];
  vi.stubGlobal("WebSocket", function open(this: object, url: string) {
    sockets.push(url);
    Object.assign(this, { close: () => {} });
  });
  const events = { manifest() {}, grown() {}, chunk() {}, missing() {}, progress() {}, state() {}, failed() {} };
  const source = openSource(src, base)(events, { time: null, rate: 0 });
  await vi.waitUntil(() => sockets.length > 0);
  source.close();
  return sockets.join();
}

describe("a scene on a server", () => {
  it.each([
    ["wss://hgs.example/v1/scenes/a/stream", "wss://hgs.example/v1/scenes/a/stream"],
    ["/view/studio", "ws://page.example:8000/v1/scenes/studio/stream"],
    ["https://hgs.example/view/studio/", "wss://hgs.example/v1/scenes/studio/stream"],
    ["https://hgs.example/v1/scenes/studio", "wss://hgs.example/v1/scenes/studio/stream"],
    ["https://hgs.example/lab/view/studio", "wss://hgs.example/lab/v1/scenes/studio/stream"],
    [
      "https://hgs.example/my%20scenes/view/a/view/b?link=x",
      "wss://hgs.example/my%20scenes/view/a/v1/scenes/b/stream?link=x",
    ],
  ])("is streamed from %s", async (src, stream) => {
    expect(await opened(src, "http://page.example:8000/")).toBe(stream);
  });
});

it("names an address at which no scene can be", () => {
  expect(() => openSource("studio.ply", "http://page.example/")).toThrow(/studio\.ply/);
  expect(() => openSource("https://", "http://page.example/")).toThrow("src https://: not an address");
});

describe("a scene in a folder", () => {
  it.each([
    ["studio/", "https://page.example/a/studio/manifest.json"],
    ["https://cdn.example/studio/manifest.json?v=2", "https://cdn.example/studio/manifest.json?v=2"],
    ["manifest.json", "https://page.example/a/manifest.json"],
  ])("is fetched from %s", (src, manifest) => {
    const fetched: string[] = [];
    vi.stubGlobal("fetch", (url: string) => {
      fetched.push(url);
      return new Promise(() => {});
    });
    vi.stubGlobal("document", { hidden: false });
    const events = { manifest() {}, grown() {}, chunk() {}, missing() {}, progress() {}, state() {}, failed() {} };
    openSource(src, "https://page.example/a/b.html")(events, { time: null, rate: 0 }).close();
    expect(fetched).toEqual([manifest]);
  });
});
