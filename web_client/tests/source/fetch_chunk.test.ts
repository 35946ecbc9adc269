import { afterEach, describe, expect, it, vi } from "vitest";
import { chunkUrl, fetchChunk } from "../../src/source/fetch_chunk";

const { signal } = new AbortController();

afterEach(() => {
  vi.unstubAllGlobals();
});

describe("fetchChunk", () => {
  it("brings the bytes past every cache", async () => {
    const answer = vi.fn().mockResolvedValue(new Response(Uint8Array.of(1, 2, 3)));
    vi.stubGlobal("fetch", answer);
    expect([...(await fetchChunk("http://here/c", signal))]).toEqual([1, 2, 3]);
    expect(answer).toHaveBeenCalledExactlyOnceWith("http://here/c", { signal, cache: "reload" });
  });

  it("says what the server answered", async () => {
    vi.stubGlobal("fetch", vi.fn().mockResolvedValue(new Response(null, { status: 404, statusText: "Not Found" })));
    await expect(fetchChunk("http://here/c", signal)).rejects.toThrow("The server answered 404: Not Found");
  });

  it("says that the server cannot be reached", async () => {
    vi.stubGlobal("fetch", vi.fn().mockRejectedValue(new TypeError("failed")));
    await expect(fetchChunk("http://here/c", signal)).rejects.toThrow("The server cannot be reached.");
  });
});

it("finds a chunk on the server of a stream, by the link that opens both", () => {
  expect(chunkUrl("ws://here/v1/scenes/s/stream", "ab")).toBe("http://here/v1/scenes/s/chunks/ab");
  expect(chunkUrl("wss://far/below/v1/scenes/s/stream?key=k", "ab")).toBe(
    "https://far/below/v1/scenes/s/chunks/ab?key=k",
  );
});
