import { afterEach, expect, it, vi } from "vitest";
import { download, retryDelay, StatusError } from "../../src/source/download";

const { signal } = new AbortController();

/** A server that answers everything with that. */
const answering = (body: string | null, init: ResponseInit = {}, url = "") =>
  vi.stubGlobal("fetch", async () => Object.defineProperty(new Response(body, init), "url", { value: url }));

afterEach(() => vi.unstubAllGlobals());

it("gives the file and where it was found", async () => {
  answering("abc", {}, "https://cdn.example/b");
  const { url, bytes } = await download("https://cdn.example/a", signal, "default", 3);
  expect([url, ...bytes]).toEqual(["https://cdn.example/b", 97, 98, 99]);
});

it.each([
  [404, true],
  [410, true],
  [403, false],
  [500, false],
])("throws the status %i, which says that there is no such file: %s", async (status, missing) => {
  answering("sorry", { status });
  const error = await download("https://cdn.example/a", signal, "default").catch((error) => error);
  expect(error).toBeInstanceOf(StatusError);
  expect(error.missing).toBe(missing);
  expect(error.message).toBe(`https://cdn.example/a: the server answered ${status}`);
});

it("takes no part of a file for the file", async () => {
  answering("abc", { status: 206 });
  await expect(download("https://cdn.example/a", signal, "default")).rejects.toThrow(StatusError);
});

it("takes no file of another length", async () => {
  answering("abc");
  await expect(download("https://cdn.example/a", signal, "default", 4)).rejects.toThrow("has 3 bytes, expected 4");
});

afterEach(() => vi.restoreAllMocks());

it("is anywhere in a span that doubles up to eight seconds", () => {
  const random = vi.spyOn(Math, "random").mockReturnValue(0.5);
  expect([0, 1, 2, 3, 4, 5, 50].map(retryDelay)).toEqual([250, 500, 1000, 2000, 4000, 4000, 4000]);
  random.mockReturnValue(0);
  expect(retryDelay(3)).toBe(0);
});
