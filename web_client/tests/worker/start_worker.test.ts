import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { zstdWasm } from "../../plugins/zstd_wasm.ts";

const address = vi.hoisted(() => ({ default: "https://cdn.example/hgs/worker.js" }));
vi.mock("../../src/worker/worker.ts?worker&url", () => address);

afterEach(() => vi.unstubAllGlobals());

/** The addresses of the workers that are started on a page of that origin, and what the blobs hold. */
async function started(origin: string): Promise<{ addresses: string[]; blobs: Blob[] }> {
  vi.resetModules();
  const addresses: string[] = [];
  const blobs: Blob[] = [];
  vi.stubGlobal("origin", origin);
  vi.stubGlobal("document", { baseURI: origin === "null" ? "about:srcdoc" : `${origin}/page/` });
  vi.stubGlobal("Worker", function start(address: string | URL) {
    addresses.push(String(address));
  });
  vi.spyOn(URL, "createObjectURL").mockImplementation((blob) => `blob:${blobs.push(blob as Blob)}`);
  const { startWorker } = await import("../../src/worker/start_worker");
  startWorker();
  startWorker();
  return { addresses, blobs };
}

it("starts the script itself on a page of its origin", async () => {
  expect((await started("https://cdn.example")).addresses[0]).toBe("https://cdn.example/hgs/worker.js");
});

it("starts the script that a bundler names by a path", async () => {
  address.default = "/static/worker.js";
  expect((await started("https://page.example")).addresses[0]).toBe("https://page.example/static/worker.js");
  address.default = "https://cdn.example/hgs/worker.js";
});

it("starts what its policy trusts where a page asks for that, and makes one policy for all players", async () => {
  const createPolicy = vi.fn((_: string, rules: { createScriptURL(url: string): string }) => ({
    createScriptURL: (url: string) => `trusted ${rules.createScriptURL(url)}`,
  }));
  vi.stubGlobal("trustedTypes", { createPolicy });
  const { addresses } = await started("https://cdn.example");
  expect(addresses[1]).toBe("trusted https://cdn.example/hgs/worker.js");
  expect(createPolicy.mock.calls.map(([name]) => name)).toEqual(["hgs-player"]);
});

it("starts a script of the page that imports it in a frame without an origin", async () => {
  const script = 'import "https://cdn.example/hgs/worker.js";';
  expect((await started("null")).addresses[0]).toBe(`data:text/javascript,${encodeURIComponent(script)}`);
});

it("starts a script of the page that imports it elsewhere, the same for all players", async () => {
  const { addresses, blobs } = await started("https://page.example");
  expect(addresses).toEqual(["blob:1", "blob:1"]);
  expect(await blobs[0].text()).toBe('import "https://cdn.example/hgs/worker.js";');
});

describe("the decompressor", () => {
  let decompressor: () => Promise<WebAssembly.Module>;
  const fetched = vi.fn<() => Promise<Response>>();

  beforeEach(async () => {
    vi.useFakeTimers();
    vi.resetModules();
    vi.stubGlobal("fetch", fetched.mockReset());
    decompressor = (await import("../../src/worker/start_worker")).decompressor;
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
});
