import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { zstdWasm } from "../../plugins/zstd_wasm.ts";

let decompressor: () => Promise<WebAssembly.Module>;
const fetched = vi.fn<() => Promise<Response>>();

beforeEach(async () => {
  vi.useFakeTimers();
  vi.resetModules();
  vi.stubGlobal("fetch", fetched.mockReset());
  decompressor = (await import("../../src/worker/decompressor")).decompressor;
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

it("is fetched once for all players", async () => {
  fetched.mockImplementation(async () => new Response(zstdWasm()));
  expect(await decompressor()).toBe(await decompressor());
  expect(fetched).toHaveBeenCalledOnce();
});

it("is asked for three times, and anew by the next player", async () => {
  fetched.mockImplementation(async () => new Response("", { status: 503 }));
  const refused = expect(decompressor()).rejects.toThrow("503");
  await vi.advanceTimersByTimeAsync(3000);
  await refused;
  expect(fetched).toHaveBeenCalledTimes(3);
  fetched.mockImplementation(async () => new Response(zstdWasm()));
  expect(await decompressor()).toBeInstanceOf(WebAssembly.Module);
});
